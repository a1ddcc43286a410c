// How tets are scored where: one scale for the mesh, or one that follows a sizing field.
#pragma once

#include "core/simplify/sizing/sizing.h"
#include "core/simplify/tet_operations/star_quality.h"

namespace palpate::simplify {

/// The scale of the scores, with the ideal volume of each place: that of the far field times the cube of the
/// relative size. An empty field costs nothing. Holds a reference to the field.
class ScoreRule {
 public:
  ScoreRule(const ScoreScale& far, const SizingField& field) : far_(far), field_(&field) {}

  ScoreScale at(const Vec3& x) const {
    if (field_->is_empty()) return far_;
    ScoreScale scale = far_;
    const double size = field_->relative_size(x);
    scale.ideal_volume *= size * size * size;
    return scale;
  }

  /// The same with another weight of the worst tets (see gain_of_score).
  ScoreRule with_gain_offset(double offset) const {
    ScoreRule result = *this;
    result.far_.gain_offset = offset;
    return result;
  }

  const ScoreScale& far() const { return far_; }
  const SizingField& field() const { return *field_; }

 private:
  ScoreScale far_;
  const SizingField* field_;
};

}  // namespace palpate::simplify

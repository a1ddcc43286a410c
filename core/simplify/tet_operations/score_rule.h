// How tets are scored where: one scale for the mesh, or one that follows a sizing field.
#pragma once

#include <algorithm>

#include "core/mesh/geometry.h"
#include "core/simplify/sizing/sizing.h"
#include "core/simplify/tet_operations/star_quality.h"
#include "core/simplify/tet_operations/working_mesh.h"

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

  /// The scale by which a collapse of (gone, survivor) to about `place` is judged. Where sizes are wanted
  /// that are far from what the mesh has, all tets are small for their place, and what counts is shape: no
  /// ideal volume above the mean around the edge.
  ScoreScale of_collapse(const WorkingMesh& mesh, Index gone, Index survivor, const Vec3& place) const {
    ScoreScale scale = at(place);
    if (!field_->has_sizes()) return scale;
    double sum = 0.0;
    double count = 0.0;
    for (const Index center : {gone, survivor}) {
      for (const Index t : mesh.star(center)) {
        const Tet& v = mesh.tets[t];
        sum += signed_volume(mesh.points[v[0]], mesh.points[v[1]], mesh.points[v[2]], mesh.points[v[3]]);
        count += 1.0;
      }
    }
    if (sum > 0.0) scale.ideal_volume = std::min(scale.ideal_volume, sum / count);
    return scale;
  }

  const ScoreScale& far() const { return far_; }
  const SizingField& field() const { return *field_; }

 private:
  ScoreScale far_;
  const SizingField* field_;
};

}  // namespace palpate::simplify

// What the worst tets of a mesh must not fall below.
#pragma once

#include <span>

#include "core/base/types.h"
#include "core/simplify/quality/batch_quality.h"
#include "core/simplify/tet_operations/working_mesh.h"

namespace palpate::simplify {

/// The least quality (of the thesis, with one ideal volume) and the least dihedral angle of a mesh, in double
/// precision. Whoever leaves no tet below either has not lowered the mesh's own least.
class QualityFloor {
 public:
  explicit QualityFloor(double ideal_volume) : ideal_volume_(ideal_volume) {}

  /// Takes what the mesh has now. Scores that the mesh knows (see ScoreScale) only save work.
  void take(const WorkingMesh& mesh);

  /// Whether tet (a, b, c, d) is no worse than the floor in both. Requires: it is positive.
  bool admits(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) const;

  /// The same for a tet of the mesh.
  bool admits(const WorkingMesh& mesh, const Tet& tet) const {
    return admits(mesh.points[tet[0]], mesh.points[tet[1]], mesh.points[tet[2]], mesh.points[tet[3]]);
  }

  /// The same for all tets around v, with v at `place`, but those that have the vertex `without` too.
  /// `scores`: theirs there, in the order of v's star, or none; they only save work.
  bool admits_star(const WorkingMesh& mesh, Index v, const Vec3& place, std::span<const float> scores = {},
                   Index without = kNoIndex) const;

  /// Cube of the least quality, and cosine of the least dihedral angle.
  double least_cube() const { return least_cube_; }
  double greatest_cosine() const { return greatest_cosine_; }

 private:
  double cube_of(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) const;
  double least_cube_with(TetBatch& batch) const;
  bool may_have_least_angle(float score) const;

  double ideal_volume_;
  double least_cube_ = 0.0;
  double greatest_cosine_ = 1.0;
};

/// The cosine of the least dihedral angle of a positive tet.
double cosine_of_least_dihedral(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

}  // namespace palpate::simplify

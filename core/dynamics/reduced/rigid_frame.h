// The six rigid motions of a body, and what takes a load's resultant and moment away.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/dynamics/finite_elements/elements.h"

namespace palpate::dynamics {

/// Small rigid motions about a body's centre, rotations in parts of its radius, so that all six have one
/// unit.
struct RigidFrame {
  Vec3 center_m;
  double radius_m = 1.0;

  /// Motion k (0 to 2: translations, 3 to 5: rotations) at a point.
  Vec3 motion(std::size_t k, const Vec3& point) const;
  /// A combination of the six.
  Vec3 at(const std::array<double, 6>& amounts, const Vec3& point) const;
};

/// Around the centre of mass. Requires: a mesh with tets of positive volume.
RigidFrame build_rigid_frame(const TetMesh& mesh);

/// The work that the weight of a body does in each of the six: the integral of f . motion for a force of
/// `force_n_m3` a unit of volume.
std::array<double, 6> work_of_weight(const TetMesh& mesh, const RigidFrame& frame, const Vec3& force_n_m3);

/// Components (bit i of an entry a vertex) that stop every rigid motion of a connected body and no more:
/// three, two and one at three vertices that lie far apart.
std::vector<std::uint8_t> pin_statically(const TetMesh& mesh, const RigidFrame& frame);

}  // namespace palpate::dynamics

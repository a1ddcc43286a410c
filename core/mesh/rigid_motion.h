// Rigid motions of a body that nothing resists.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/mesh/boundary_problem.h"
#include "core/mesh/tet_mesh.h"

namespace palpate {

/// A small rigid motion of one connected part of a mesh: a translation along `axis`, or a rotation about it.
struct RigidMotion {
  Index part = 0;  ///< the smallest vertex of the part
  bool is_rotation = false;
  Vec3 axis;   ///< of length 1
  Vec3 point;  ///< a rotation's: on the axis, the one nearest to the mean of the part's vertices
};

/// The axes (bit i: axis i) along which held faces and elastic supports resist each vertex. A support without
/// stiffness, weight or area resists nothing.
///
/// Shape:  one entry a vertex. Requires: faces of the mesh.
std::vector<std::uint8_t> resisted_axes(const TetMesh& mesh, const BoundaryProblem& problem);

/// The motions of each connected part that move no vertex along a resisted axis: a basis of them,
/// translations first and along the coordinate axes where they can be. A consistent mass is positive
/// definite, so what a supported face resists is what its three vertices do.
///
/// A motion counts as free if the mean square of what it moves along resisted axes is below 1e-10, in parts
/// of its size: all that is held then lies within about 1e-5 of the part's size of a line or a point.
/// Shape:  `resisted` has one entry a vertex, as resisted_axes gives them; a vertex of no tet is left out.
std::vector<RigidMotion> find_free_motions(const TetMesh& mesh, std::span<const std::uint8_t> resisted);

/// "a translation along (1, 0, 0)", "a rotation about (0, 0, 1) through (0, 0.02, 0) m".
std::string rigid_motion_text(const RigidMotion& motion);

}  // namespace palpate

// Where a finger touches a body: faces of the skin around a place.
#pragma once

#include <span>
#include <vector>

#include "core/dynamics/elasticity/loads.h"
#include "core/mesh/boundary_problem.h"
#include "core/mesh/tet_mesh.h"

namespace palpate::live {

/// The part of the skin that a round pad takes hold of: the weight of a face is the share of 64 equal parts
/// of it whose centroids lie within `radius_m` of `center_m`. Faces that look away from `outward` are left
/// out, so that a pad on a thin part does not hold its other side too. If that is nothing, the face nearest
/// to the centre of those that look outward is taken whole.
///
/// Requires: at least one face; a radius above zero.
FacePatch find_pad(std::span<const Vec3> rest, std::span<const Triangle> skin, const Vec3& center_m,
                   const Vec3& outward, double radius_m);

/// The mean outward normal, of length 1, of the faces around a vertex of the skin, by their areas.
Vec3 skin_normal(std::span<const Vec3> rest, std::span<const Triangle> skin, Index vertex);

/// The patch as elastic faces with the consistent mass of linear shape functions (build_loads).
std::vector<dynamics::SupportFace> pad_faces(std::span<const Vec3> rest, const FacePatch& patch,
                                             double stiffness_pa_per_m);

}  // namespace palpate::live

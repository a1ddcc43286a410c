// The judge's figures of a displacement: how far it is from a reference, by arithmetic of its own.
#pragma once

#include <span>
#include <vector>

#include "core/base/types.h"
#include "core/mesh/tet_mesh.h"

namespace palpate::judge {

/// Errors against a reference at the same points, with each point's share of the volume as its weight.
struct DisplacementError {
  double relative_l2 = 0.0;   ///< sqrt(sum w |u - r|^2 / sum w |r|^2)
  double relative_max = 0.0;  ///< max |u - r| / max |r|
  double relative_energy =
      0.0;  ///< sqrt(a(u - r, u - r) / a(r, r)), a = linear elasticity on linear tets of the mesh
  std::size_t worst_point = 0;  ///< where relative_max is taken
};

/// Compares two fields given at the vertices of `mesh` (points in m): `field` of a contestant, `truth` of the
/// reference. Throws: ContractError for other sizes; InputError for a field that is not finite or a reference
/// that is zero.
DisplacementError compare_displacement(const TetMesh& mesh, std::span<const Vec3> field,
                                       std::span<const Vec3> truth, double lambda_pa, double mu_pa);

/// A field on the vertices of `source`, linear in each tet, evaluated at `points`: barycentric inside;
/// outside, at the nearest point of the nearest boundary face. `outside` counts those.
struct TransferredField {
  std::vector<Vec3> value;
  std::size_t outside = 0;
  double farthest_outside = 0.0;  ///< largest distance of a point from `source`, in m
};
TransferredField transfer_field(const TetMesh& source, std::span<const Vec3> field,
                                std::span<const Vec3> points);

}  // namespace palpate::judge

// The judge's figures of a displacement: how far it is from a reference, by arithmetic of its own.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/base/types.h"
#include "core/mesh/tet_mesh.h"

namespace palpate::judge {

/// How large a field of displacements is. A field has one row a vertex of the mesh (n rows: linear in each
/// tet), or one row more for the midpoint of each edge (n + e rows: quadratic; edges a < b, sorted, as
/// build_edges numbers them).
struct DisplacementSize {
  double l2 = 0.0;  ///< sqrt(sum w |u|^2), w the share of the volume of each point, in m^3 (below)
  double deformation =
      0.0;              ///< the same of u less its best rigid motion (core/judge/displacement/rigid_part.h)
  double max = 0.0;     ///< max |u|
  double energy = 0.0;  ///< sqrt(a(u, u)), a(u, u) = integral of lambda (tr e)^2 + 2 mu e : e
  std::size_t max_point = 0;  ///< the first row at which `max` is taken
};

/// Measures a field, in linear time. A tet whose volume is not positive in double precision has no part in
/// it. Throws: ContractError for other sizes or a material that is not positive (mu > 0, 3 lambda + 2 mu >
/// 0).
DisplacementSize measure_displacement(const TetMesh& mesh, std::span<const Vec3> field, double lambda_pa,
                                      double mu_pa);

/// Each row's share of the volume: for n rows a quarter of the tets around a vertex; for n + e rows 1/32 of
/// the tets around a vertex and 7/48 of those around an edge, which is what the vertices of the uniform
/// refinement have, averaged over the three ways to divide the inner octahedron.
std::vector<double> volume_shares(const TetMesh& mesh, std::size_t rows);

/// Adds the midpoint rows to a field of n rows, each the mean of the edge's ends, and leaves one that has
/// them.
std::vector<Vec3> with_midpoints(const TetMesh& mesh, std::span<const Vec3> field);

/// Errors against a reference at the same points, with each point's share of the volume as its weight.
struct DisplacementError {
  double relative_l2 = 0.0;  ///< sqrt(sum w |u - r|^2 / sum w |r|^2)
  /// The same after the best rigid motion is taken off u - r and off r, each its own. A support that gives
  /// lets a body move far and strain little; this says how wrong the strained shape is.
  double relative_deformation = 0.0;
  double relative_max = 0.0;     ///< max |u - r| / max |r|
  double relative_energy = 0.0;  ///< sqrt(a(u - r, u - r) / a(r, r)), a = linear elasticity on the mesh
  std::size_t worst_point = 0;   ///< where relative_max is taken
  double rigid_share = 0.0;      ///< of sum w |r|^2: what r's best rigid motion has of it
};

/// Compares two fields given at the vertices of `mesh` (points in m), or both at its n + e quadratic nodes:
/// `field` of a contestant, `truth` of the reference. Throws: ContractError for other sizes; InputError for a
/// field that is not finite, or a reference that is zero or strains nothing.
DisplacementError compare_displacement(const TetMesh& mesh, std::span<const Vec3> field,
                                       std::span<const Vec3> truth, double lambda_pa, double mu_pa);

/// Throws: InputError with `name` for a vector that is not finite.
void require_finite(std::span<const Vec3> field, const char* name);

/// A field at other points than those it was given at.
struct TransferredField {
  std::vector<Vec3> value;        ///< one a point
  std::size_t outside = 0;        ///< points farther out than rounding (1e-12 of the box's diagonal)
  double farthest_outside = 0.0;  ///< largest distance of a point from the field's mesh, in m
};

/// A field of `source`, linear in each tet (n rows) or quadratic (n + e rows), evaluated at `points`: by its
/// shape functions inside; outside, at the nearest point of the nearest boundary face. Time: a search in
/// trees of boxes for each point. Throws: ContractError for other sizes or no tets, InputError for numbers
/// that are not finite.
TransferredField transfer_field(const TetMesh& source, std::span<const Vec3> field,
                                std::span<const Vec3> points);

}  // namespace palpate::judge

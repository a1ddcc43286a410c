// How far a displacement is from a known solution, by quadrature of the judge's own.
#pragma once

#include <array>
#include <functional>
#include <span>

#include "core/base/types.h"
#include "core/mesh/tet_mesh.h"

namespace palpate::judge {

/// The error of a field as a function in space, not at its nodes alone.
struct SolutionError {
  double l2 = 0.0;            ///< sqrt(integral |u - truth|^2), in m^(5/2)
  double relative_l2 = 0.0;   ///< over sqrt(integral |truth|^2)
  double relative_max = 0.0;  ///< max |u - truth| / max |truth| over the quadrature points
};

/// Integrates over the tets, with 5^3 Gauss points each: exact for polynomials of degree 7.
///
/// Shape:  `field` holds one value a vertex (linear in each tet), or one more an edge midpoint (quadratic;
///         edges a < b, sorted); `truth` is asked at points of the tets.
/// Throws: ContractError for other sizes; InputError if the field or the truth is not finite, or the truth
///         is zero.
SolutionError compare_with_solution(const TetMesh& mesh, std::span<const Vec3> field,
                                    const std::function<Vec3(const Vec3&)>& truth);

/// Stress of linear elasticity at a vertex, lambda (tr e) I + 2 mu e, by rows, in Pa: the mean over the tets
/// around it, weighted by volume, of each one's stress there. Throws: ContractError for other sizes or no
/// such tet.
std::array<Vec3, 3> stress_at_vertex(const TetMesh& mesh, std::span<const Vec3> field, Index vertex,
                                     double lambda_pa, double mu_pa);

/// Observed order of convergence between two meshes with so many cells a side:
/// log(coarse / fine) / log(fine_cells / coarse_cells). Requires: errors above 0, coarse_cells < fine_cells.
double observed_order(double coarse_error, double coarse_cells, double fine_error, double fine_cells);

}  // namespace palpate::judge

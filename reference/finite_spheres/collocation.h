// The method of finite spheres by point collocation: the equations hold at the spheres' centres.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "core/mesh/boundary_problem.h"
#include "reference/finite_spheres/sphere_field.h"

namespace palpate::reference {

/// The derivatives of a field at a centre, as sums over the values at the centres around it.
///
/// Shape:  first and second have one entry a neighbour, the centre itself among them; first in 1/m, second
/// (xx, yy, zz, yz, xz, xy) in 1/m^2.
struct DerivativeStencil {
  std::vector<Index> neighbours;
  std::vector<Vec3> first;
  std::vector<std::array<double, 6>> second;
};

/// Those of the quadratic polynomial through the value at the centre that is nearest to the others', each
/// weighed with the sphere's weight there: exact for a quadratic field. A sphere reaches the centres within
/// its own radius in its part of the body (build_spheres). One that reaches too few, or in too flat a
/// pattern, is made a quarter larger until it does not.
///
/// Returns: one stencil a vertex. Throws: InputError where the whole body is not enough.
///
/// Source: B. Nayroles, G. Touzot and P. Villon, Computational Mechanics 10 (1992), 307-318 (diffuse
/// derivatives); T. Liszka and J. Orkisz, Computers and Structures 11 (1980), 83-95 (through the centre).
std::vector<DerivativeStencil> build_stencils(const TetMesh& mesh, const Spheres& spheres);

/// What came of it.
struct CollocationResult {
  std::vector<Vec3> displacement_m;  ///< at the vertices
  bool converged = false;
  double residual_relative = 0.0;  ///< largest over the rows, each over the sum of its terms' sizes
  std::size_t entries = 0;         ///< of the matrix
  std::size_t factor_entries = 0;
  double net_force_share = 0.0;  ///< forces out of balance over those that act: no equation asks for it
};

/// Solves
///
///   inside          (lambda + mu) grad div u + mu lap u + b = 0
///   on the boundary sum over the vertex's faces of A / 3 (sigma n + w kappa (u - by) - w t) - F
///                   = V ((lambda + mu) grad div u + mu lap u + b)
///   held            u = by
///
/// at each moving vertex; those at rest have u = 0. A / 3 is the vertex's part of a face, w the part of the
/// face that belongs to a region, F a force on the vertex, V a quarter of its tets: what the tractions of a
/// boundary cell leave over, its inside takes up (E. Onate, Comput. Methods Appl. Mech. Engrg. 151 (1998),
/// 233-265). With V = 0, tractions alone, displacements were off by as much as they are, and more. The matrix
/// is not symmetric; it is factored by Eigen's sparse LU.
CollocationResult solve_collocation(const TetMesh& mesh, const BoundaryProblem& problem,
                                    const std::vector<DerivativeStencil>& stencils,
                                    const std::vector<Index>& moving);

}  // namespace palpate::reference

// Loads and supports of a body whose displacement is that of a lattice around it.
#pragma once

#include <span>
#include <vector>

#include "core/dynamics/linear_algebra/block_matrix.h"
#include "core/mesh/boundary_problem.h"
#include "core/mesh/tet_mesh.h"
#include "reference/lattices/lattice_body.h"

namespace palpate::reference {

/// Loads on the nodes of a lattice, and what elastic supports do to them:
///
///   potential = 1/2 u^T S u - share pulls . u + share^2 rest_energy_j - share dead . u
///
/// S ties nodes axis by axis: entry k of row r is diag(stiffness[k]) between nodes rows[r] and columns[k].
///
/// Shape:  dead_n and pull_n one entry a node; offsets one more than rows; columns and stiffness one entry
/// each.
struct EmbeddedLoads {
  std::vector<Vec3> dead_n;
  std::vector<Vec3> pull_n;
  double rest_energy_j = 0.0;
  std::vector<Index> rows;
  std::vector<Index> offsets{0};
  std::vector<Index> columns;
  std::vector<Vec3> stiffness_n_per_m;
};

/// Brings a problem to the nodes of a lattice, with u the lattice's own field:
///
///   gravity, body forces, forces on vertices  as linear elements have them at the vertices f, then W^T f
///   tractions, supports                       integrals over the faces, cut at the planes between the cells,
///   seven points a
///                                             part: exact on faces along the cells
///   held faces                                as a support of stiffness LatticeBody::held_pa_per_m, along
///   the held axes
///
/// Throws: as dynamics::build_loads.
EmbeddedLoads embed_loads(const LatticeBody& body, const TetMesh& mesh, const BoundaryProblem& problem);

/// Adds the dead loads and the forces of the supports, in N; `share` multiplies loads and places.
void add_load_forces(const EmbeddedLoads& loads, std::span<const Vec3> u, double share,
                     std::span<Vec3> force);

/// The potential above, in J.
double load_energy(const EmbeddedLoads& loads, std::span<const Vec3> u, double share);

/// Adds S, in N/m. Requires: the pattern of build_lattice_pattern.
void add_load_stiffness(const EmbeddedLoads& loads, dynamics::BlockMatrix& matrix);

/// Sum of all forces on the body.
Vec3 total_force(const EmbeddedLoads& loads, std::span<const Vec3> u, double share);

}  // namespace palpate::reference

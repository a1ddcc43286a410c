// Loads and supports of a body whose displacement is that of a lattice around it.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/dynamics/linear_algebra/block_matrix.h"
#include "core/mesh/boundary_problem.h"
#include "core/mesh/tet_mesh.h"
#include "core/springs/lattice/embedding.h"
#include "reference/lattices/lattice_body.h"

namespace palpate::reference {

/// What pulls a point of a face to a place: 1/2 sum over axes of k_i (u_i - by_i)^2.
struct PointSpring {
  std::array<double, 3> stiffness_n_per_m{};
  Vec3 by_m;
  bool is_held = false;  ///< the penalty of a held face
};

/// Loads on the nodes of a lattice, and springs at points within its cells.
///
/// Shape:  dead_n one entry a node; springs one a point of `at`.
struct EmbeddedLoads {
  std::vector<Vec3> dead_n;
  springs::Embedding at;
  std::vector<PointSpring> springs;
};

/// Brings a problem to the nodes of a lattice, with u the lattice's own field:
///
///   gravity, body forces, forces on vertices  as linear elements have them at the vertices f, then W^T f
///   tractions, supports                       integrals over the faces, seven points each
///   held faces                                as a support of stiffness LatticeBody::held_pa_per_m, along
///   the held axes
///
/// Throws: as dynamics::build_loads.
EmbeddedLoads embed_loads(const LatticeBody& body, const TetMesh& mesh, const BoundaryProblem& problem);

/// Adds the dead loads and the forces of the springs, in N; `share` multiplies loads and places.
void add_load_forces(const EmbeddedLoads& loads, std::span<const Vec3> u, double share,
                     std::span<Vec3> force);

/// Energy of the springs less the work of the dead loads, in J.
double load_energy(const EmbeddedLoads& loads, std::span<const Vec3> u, double share);

/// Adds the springs' stiffness, in N/m. Requires: the pattern of build_lattice_pattern.
void add_load_stiffness(const EmbeddedLoads& loads, dynamics::BlockMatrix& matrix);

/// Sum of all forces on the body.
Vec3 total_force(const EmbeddedLoads& loads, std::span<const Vec3> u, double share);

/// How far the worst point of the held faces is from where it is held.
double worst_held_error(const EmbeddedLoads& loads, std::span<const Vec3> u);

}  // namespace palpate::reference

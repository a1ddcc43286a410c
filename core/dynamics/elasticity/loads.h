// Loads and supports of a BoundaryProblem, brought to the vertices of one mesh.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/dynamics/linear_algebra/block_matrix.h"
#include "core/mesh/boundary_problem.h"
#include "core/mesh/tet_mesh.h"

namespace palpate::dynamics {

/// A face of an elastic support with the consistent mass of linear shape functions: the energy
/// 1/2 c sum over i, j of (1 + delta_ij) (u_i - by) . (u_j - by), c = stiffness x weight x area / 12.
struct SupportFace {
  Triangle face;
  double coefficient_n_per_m = 0.0;
  Vec3 by_m;
};

/// What acts on the vertices.
///
/// Shape:  force_n, held (bit i: axis i) and held_by_m hold one entry a vertex.
struct Loads {
  std::vector<Vec3>
      force_n;  ///< gravity, body forces, tractions and nodal forces, consistent with linear shape functions
  std::vector<SupportFace> supports;
  std::vector<std::uint8_t> held;
  std::vector<Vec3> held_by_m;
};

/// Brings a problem to the vertices. Throws: InputError for a vertex that is out of range, a weight outside
/// (0, 1], a negative support stiffness, or a vertex that two clauses hold at different places.
Loads build_loads(const TetMesh& mesh, const BoundaryProblem& problem);

/// Throws InputError if a connected part of the mesh can move as a rigid body: it names the motion
/// (core/mesh/rigid_motion.h).
void require_no_rigid_motion(const TetMesh& mesh, const Loads& loads);

/// The part of the potential that is not elastic: energy of the supports minus the work of the dead loads, in
/// J. `scale` multiplies the loads and what moves the supports.
double load_energy(const Loads& loads, std::span<const Vec3> displacement, double scale);

/// Adds the dead loads and the forces of the supports, in N.
void add_load_forces(const Loads& loads, std::span<const Vec3> displacement, double scale,
                     std::span<Vec3> force);

/// Adds the stiffness of the supports, in N/m.
void add_support_tangent(const Loads& loads, BlockMatrix& matrix);

}  // namespace palpate::dynamics

// Loads and supports of a BoundaryProblem, brought to the nodes of linear or quadratic elements.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/dynamics/finite_elements/elements.h"
#include "core/mesh/boundary_problem.h"

namespace palpate::dynamics {

/// A face of an elastic support: the energy 1/2 c sum over i, j of m_ij (u_i - by) . (u_j - by), m the
/// unit_face_mass of the order, c = stiffness x weight x area.
struct ElasticFace {
  std::array<Index, 6> nodes{};
  double coefficient_n_per_m = 0.0;
  Vec3 by_m;
  std::size_t support = 0;  ///< place in the problem's list
};

/// What acts on the nodes, consistent with their shape functions.
///
/// Shape:  force_n, held (bit i: axis i) and held_by_m hold one entry a node.
struct NodeLoads {
  std::vector<Vec3> force_n;  ///< tractions, nodal forces, and body forces if they were asked for
  std::vector<ElasticFace> faces;
  std::vector<std::uint8_t> held;
  std::vector<Vec3> held_by_m;
};

/// Whether gravity and body forces are among the forces.
enum class BodyForces { kLeaveOut, kInclude };

/// Brings a problem to the nodes. Throws: InputError as build_loads (core/dynamics/elasticity/loads.h).
NodeLoads build_node_loads(const TetMesh& mesh, const ElementSpace& space, const BoundaryProblem& problem,
                           BodyForces body_forces);

/// Adds the stiffness of the supports to the pattern of a body. Throws: ContractError if it lacks a pair.
void add_support_stiffness(const NodeLoads& loads, int order, BlockMatrix& matrix);

/// Adds what supports that are moved pull with, S by, in N.
void add_support_pull(const NodeLoads& loads, int order, std::span<Vec3> force);

/// What supports hold at a displacement: their energy in J, and the force of each on the body in N, the
/// integral of stiffness x (by - u) over its faces.
struct SupportFigures {
  double energy_j = 0.0;
  std::vector<Vec3> forces_n;
};
/// Shape: displacement has one entry a node. `supports` is how many the problem has.
SupportFigures measure_supports(const NodeLoads& loads, int order, std::span<const Vec3> displacement_m,
                                std::size_t supports);

}  // namespace palpate::dynamics

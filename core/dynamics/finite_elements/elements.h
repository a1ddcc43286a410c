// Linear and quadratic tetrahedra of linear elasticity: their nodes, stiffness and consistent mass.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "core/dynamics/linear_algebra/block_matrix.h"
#include "core/mesh/boundary_problem.h"
#include "core/mesh/subdivision/refinement.h"
#include "core/mesh/tet_mesh.h"

namespace palpate::dynamics {

/// The nodes of elements of order 1 (the vertices) or 2 (the vertices, then the midpoints of build_edges).
///
/// Shape:  points has one entry a node; tet_nodes 4 or 10 a tet: the corners, then the midpoints of
/// kTetEdges.
struct ElementSpace {
  int order = 1;
  EdgeNumbers edges;
  std::vector<Vec3> points;
  std::vector<Index> tet_nodes;

  std::size_t nodes() const { return points.size(); }
  std::size_t nodes_per_tet() const { return order == 1 ? 4 : 10; }
  std::size_t nodes_per_face() const { return order == 1 ? 3 : 6; }
};

/// Throws: ContractError for another order.
ElementSpace build_element_space(const TetMesh& mesh, int order);

/// The nodes of a face: its corners a, b, c, then (order 2) the midpoints of ab, bc and ca.
/// Requires: a face of the mesh. The last three are kNoIndex at order 1.
std::array<Index, 6> face_nodes(const ElementSpace& space, const Triangle& face);

/// A number for each pair of a face's nodes, in the order of face_nodes.
using FaceMass = std::array<std::array<double, 6>, 6>;
/// Integral of phi_i phi_j over a face of area 1. Exact.
FaceMass unit_face_mass(int order);

/// The matrices of a body.
///
/// Shape:  mass_kg has one entry a block of the stiffness, in its pattern: M = mass (x) I.
struct ElementMatrices {
  BlockMatrix stiffness;
  std::vector<double> mass_kg;
};

/// K_ab = integral of lambda g_a g_b^T + mu (g_b g_a^T + g_a . g_b I) and M_ab = integral of rho phi_a phi_b
/// over straight tetrahedra, g the gradients of the shape functions phi; exact.
/// Source: O. C. Zienkiewicz and R. L. Taylor, The Finite Element Method, 5th ed. (2000).
ElementMatrices build_element_matrices(const TetMesh& mesh, const ElementSpace& space,
                                       const Material& material);

/// y = M x.
void multiply_mass(const ElementMatrices& body, std::span<const Vec3> x, std::span<Vec3> y);

}  // namespace palpate::dynamics

// The tensor-mass model: linear elasticity kept as one 3 x 3 tensor a vertex and one an edge.
#pragma once

#include <span>
#include <vector>

#include "core/dynamics/elasticity/loads.h"
#include "core/dynamics/linear_algebra/matrix3.h"
#include "core/mesh/boundary_problem.h"
#include "core/mesh/subdivision/refinement.h"
#include "core/mesh/tet_mesh.h"

namespace palpate::reference {

/// The tensors of a body at rest, in N/m.
///
/// A tet with the inward area vectors m_i of its faces (twice the area, opposite to vertex i) and the volume
/// V has
///   K_ij = (lambda m_i m_j^T + mu m_j m_i^T + mu (m_i . m_j) I) / (36 V);
/// they are added up over the tets around each vertex (i = j) and each edge (i < j; K_ji is the transpose).
struct TensorMass {
  EdgeNumbers edges;
  std::vector<dynamics::Mat3> vertex;  ///< one a vertex, symmetric
  std::vector<dynamics::Mat3>
      edge;  ///< one an edge {a, b}, a < b: the force on a when b moves, but for its sign
};

/// Builds the tensors. Requires: positive tets, points in m. Source: Cotin, Delingette and Ayache (2000).
TensorMass build_tensor_mass(const TetMesh& mesh, const Material& material);

/// Adds the stiffness of elastic supports to the tensors.
void add_supports(const std::vector<dynamics::SupportFace>& supports, TensorMass& tensors);

/// Adds the forces on the vertices, in N: F_i -= K_ii u_i + sum over its edges of K_ij u_j. Gathered by
/// vertex and edge, without tets, as the model does step by step. A rigid rotation by an angle t gives forces
/// of the order of 1 - cos t: the model's known fault. Throws: ContractError if the sizes differ.
void add_tensor_forces(const TensorMass& tensors, std::span<const Vec3> displacement, std::span<Vec3> force);

}  // namespace palpate::reference

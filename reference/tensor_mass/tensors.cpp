#include "reference/tensor_mass/tensors.h"

#include <array>

#include "core/base/error.h"
#include "core/mesh/geometry.h"

namespace palpate::reference {

using dynamics::kIdentity;
using dynamics::Mat3;
using dynamics::outer;
using dynamics::transpose;

namespace {

/// K_ij of one tet from its area vectors.
Mat3 tet_tensor(const Vec3& m_i, const Vec3& m_j, double lambda, double mu, double volume) {
  return (1.0 / (36.0 * volume)) *
         (lambda * outer(m_i, m_j) + mu * outer(m_j, m_i) + (mu * dot(m_i, m_j)) * kIdentity);
}

/// Adds K to the tensor of the edge from a to b, whichever of them is smaller.
void add_edge(TensorMass& tensors, Index a, Index b, const Mat3& k) {
  tensors.edge[tensors.edges.of(a, b)] += a < b ? k : transpose(k);
}

}  // namespace

TensorMass build_tensor_mass(const TetMesh& mesh, const Material& material) {
  TensorMass tensors;
  tensors.edges = build_edge_numbers(mesh);
  tensors.vertex.resize(mesh.points.size());
  tensors.edge.resize(tensors.edges.edges.size());
  const double lambda = material.lambda_pa();
  const double mu = material.mu_pa();
  for (const Tet& tet : mesh.tets) {
    const auto point = [&](int local) { return mesh.points[tet[static_cast<std::size_t>(local)]]; };
    const double volume = signed_volume(point(0), point(1), point(2), point(3));
    require(volume > 0.0, "build_tensor_mass: a tet is not positive");
    std::array<Vec3, 4> area;
    for (std::size_t i = 0; i < 4; ++i) {
      const auto& face = kTetFaces[i];
      area[i] = cross(point(face[2]) - point(face[0]), point(face[1]) - point(face[0]));
    }
    for (std::size_t i = 0; i < 4; ++i) {
      tensors.vertex[tet[i]] += tet_tensor(area[i], area[i], lambda, mu, volume);
      for (std::size_t j = i + 1; j < 4; ++j) {
        add_edge(tensors, tet[i], tet[j], tet_tensor(area[i], area[j], lambda, mu, volume));
      }
    }
  }
  return tensors;
}

void add_supports(const std::vector<dynamics::SupportFace>& supports, TensorMass& tensors) {
  for (const dynamics::SupportFace& support : supports) {
    const Mat3 part = support.coefficient_n_per_m * kIdentity;
    for (std::size_t i = 0; i < 3; ++i) {
      tensors.vertex[support.face[i]] += 2.0 * part;
      add_edge(tensors, support.face[i], support.face[(i + 1) % 3], part);
    }
  }
}

void add_tensor_forces(const TensorMass& tensors, std::span<const Vec3> displacement, std::span<Vec3> force) {
  require(displacement.size() == tensors.vertex.size() && force.size() == displacement.size(),
          "add_tensor_forces: one displacement and one force a vertex");
  for (std::size_t v = 0; v < force.size(); ++v) force[v] = force[v] - tensors.vertex[v] * displacement[v];
  for (std::size_t e = 0; e < tensors.edge.size(); ++e) {
    const auto& [a, b] = tensors.edges.edges[e];
    force[a] = force[a] - tensors.edge[e] * displacement[b];
    force[b] = force[b] - transpose(tensors.edge[e]) * displacement[a];
  }
}

}  // namespace palpate::reference

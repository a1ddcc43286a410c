#include "core/springs/training/training_terms.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/base/error.h"
#include "core/mesh/geometry.h"
#include "core/mesh/topology.h"

namespace palpate::springs {
namespace {

// Six times the gradients of a tet's shape functions times its volume: outward area vectors, turned inward.
std::array<Vec3, 4> scaled_gradients(const TetMesh& mesh, const Tet& tet) {
  std::array<Vec3, 4> gradients;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto& face = kTetFaces[i];
    const Vec3& a = mesh.points[tet[face[0]]];
    gradients[i] = -1.0 * cross(mesh.points[tet[face[1]]] - a, mesh.points[tet[face[2]]] - a);
  }
  return gradients;
}

double volume_of(const TetMesh& mesh, const Tet& tet) {
  return signed_volume(mesh.points[tet[0]], mesh.points[tet[1]], mesh.points[tet[2]], mesh.points[tet[3]]);
}

void end_term(double constant, RankOneTerms& terms) {
  terms.offsets.push_back(terms.component.size());
  terms.constant.push_back(constant);
}

void add_vector(Index vertex, const Vec3& value, RankOneTerms& terms) {
  terms.component.insert(terms.component.end(), {3 * vertex, 3 * vertex + 1, 3 * vertex + 2});
  terms.coefficient.insert(terms.coefficient.end(), {value.x, value.y, value.z});
}

void require_positive(double modulus_pa) {
  require(modulus_pa > 0.0 && std::isfinite(modulus_pa), "training: a modulus to start from is positive");
}

}  // namespace

void add_spring_terms(const TetMesh& mesh, const SpringNetwork& network, double least_share,
                      RankOneTerms& terms) {
  require(least_share > 0.0, "training: the least share of the mean stiffness is positive");
  double mean = 0.0;
  for (const double k : network.stiffness_n_per_m) mean += k;
  mean /= static_cast<double>(std::max<std::size_t>(1, network.springs.size()));
  require(mean > 0.0 && std::isfinite(mean), "training: the springs to start from have a stiffness");
  for (std::size_t s = 0; s < network.springs.size(); ++s) {
    const auto [a, b] = network.springs[s];
    const Vec3 d = mesh.points[b] - mesh.points[a];
    const Vec3 unit = (1.0 / length(d)) * d;
    add_vector(a, -1.0 * unit, terms);
    add_vector(b, unit, terms);
    end_term(std::max(network.stiffness_n_per_m[s], least_share * mean), terms);
  }
}

void add_vertex_dilatation_terms(const TetMesh& mesh, double modulus_pa, RankOneTerms& terms) {
  // tr eps_n = sum over its tets of (V_T / 4) div u_T / V_n, V_T div u_T = sum of V_T grad N . u.
  require_positive(modulus_pa);
  const VertexStars stars = build_vertex_stars(mesh);
  std::vector<std::pair<Index, Vec3>> parts;
  for (Index vertex = 0; vertex < mesh.points.size(); ++vertex) {
    parts.clear();
    double volume = 0.0;
    for (const Index t : stars.of(vertex)) {
      volume += volume_of(mesh, mesh.tets[t]) / 4.0;
      const auto gradients = scaled_gradients(mesh, mesh.tets[t]);
      for (std::size_t i = 0; i < 4; ++i) parts.emplace_back(mesh.tets[t][i], (1.0 / 24.0) * gradients[i]);
    }
    if (parts.empty()) continue;
    std::stable_sort(parts.begin(), parts.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    const double scale = 1.0 / std::sqrt(volume);
    for (std::size_t i = 0; i < parts.size();) {
      const Index at = parts[i].first;
      Vec3 sum;
      for (; i < parts.size() && parts[i].first == at; ++i) sum = sum + parts[i].second;
      add_vector(at, scale * sum, terms);
    }
    end_term(modulus_pa, terms);
  }
}

void add_tet_dilatation_terms(const TetMesh& mesh, double modulus_pa, RankOneTerms& terms) {
  require_positive(modulus_pa);
  for (const Tet& tet : mesh.tets) {
    const double scale = 1.0 / (6.0 * std::sqrt(volume_of(mesh, tet)));
    const auto gradients = scaled_gradients(mesh, tet);
    for (std::size_t i = 0; i < 4; ++i) add_vector(tet[i], scale * gradients[i], terms);
    end_term(modulus_pa, terms);
  }
}

}  // namespace palpate::springs

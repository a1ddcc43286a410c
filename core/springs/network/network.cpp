#include "core/springs/network/network.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/mesh/geometry.h"
#include "core/mesh/topology.h"

namespace palpate::springs {
namespace {

double tet_volume(const TetMesh& mesh, const Tet& tet) {
  return signed_volume(mesh.points[tet[0]], mesh.points[tet[1]], mesh.points[tet[2]], mesh.points[tet[3]]);
}

Vec3 barycenter(const TetMesh& mesh, const Tet& tet) {
  return 0.25 * (mesh.points[tet[0]] + mesh.points[tet[1]] + mesh.points[tet[2]] + mesh.points[tet[3]]);
}

void add_face_opposite_pairs(const TetMesh& mesh, std::vector<Edge>& pairs) {
  for (const Face& face : build_faces(mesh)) {
    if (face.tets[1] == kNoIndex) continue;
    const Index a = apex_of(mesh.tets[face.tets[0]], face.vertices);
    const Index b = apex_of(mesh.tets[face.tets[1]], face.vertices);
    if (a != b) pairs.push_back({std::min(a, b), std::max(a, b)});
  }
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
}

}  // namespace

Index apex_of(const Tet& tet, const Triangle& face) {
  for (const Index v : tet) {
    if (std::find(face.begin(), face.end(), v) == face.end()) return v;
  }
  throw ContractError("apex_of: a tet lies in its face");
}

SpringNetwork build_spring_network(const TetMesh& mesh, bool face_opposite) {
  SpringNetwork network;
  network.springs = build_edges(mesh);
  if (face_opposite) add_face_opposite_pairs(mesh, network.springs);
  network.rest_length_m.reserve(network.springs.size());
  for (const auto& [a, b] : network.springs)
    network.rest_length_m.push_back(length(mesh.points[b] - mesh.points[a]));
  network.stiffness_n_per_m.assign(network.springs.size(), 0.0);
  return network;
}

std::vector<double> build_influence_volumes(const TetMesh& mesh) {
  std::vector<double> volumes(mesh.points.size(), 0.0);
  for (const Tet& tet : mesh.tets) {
    const double quarter = 0.25 * std::abs(tet_volume(mesh, tet));
    for (const Index v : tet) volumes[v] += quarter;
  }
  return volumes;
}

std::vector<double> build_lumped_masses(const TetMesh& mesh, double density_kg_m3) {
  if (!(density_kg_m3 > 0.0) || !std::isfinite(density_kg_m3))
    throw InputError("density", 0, "a finite number of kg/m^3 above 0", std::to_string(density_kg_m3));
  std::vector<double> masses = build_influence_volumes(mesh);
  for (double& mass : masses) mass *= density_kg_m3;
  return masses;
}

Vec3 geometric_center(const TetMesh& mesh) {
  require(!mesh.tets.empty(), "geometric_center: no tets");
  Vec3 sum;
  for (const Tet& tet : mesh.tets) sum = sum + barycenter(mesh, tet);
  return (1.0 / static_cast<double>(mesh.tets.size())) * sum;
}

Vec3 center_of_mass(const TetMesh& mesh) {
  Vec3 moment;
  double volume = 0.0;
  for (const Tet& tet : mesh.tets) {
    const double v = tet_volume(mesh, tet);
    moment = moment + v * barycenter(mesh, tet);
    volume += v;
  }
  require(volume > 0.0, "center_of_mass: no volume");
  return (1.0 / volume) * moment;
}

std::vector<std::array<Index, 6>> build_tet_springs(const TetMesh& mesh, const SpringNetwork& network) {
  // Springs are sorted, so those with the same first vertex lie together.
  std::vector<Index> first(mesh.points.size() + 1, 0);
  for (const auto& [a, b] : network.springs) ++first[a + 1];
  for (std::size_t v = 1; v < first.size(); ++v) first[v] += first[v - 1];
  std::vector<std::array<Index, 6>> tet_springs(mesh.tets.size());
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    for (std::size_t i = 0; i < 6; ++i) {
      const auto [a, b] = std::minmax(mesh.tets[t][kTetEdges[i][0]], mesh.tets[t][kTetEdges[i][1]]);
      Index s = first[a];
      while (s < first[a + 1] && network.springs[s][1] != b) ++s;
      require(s < first[a + 1], "build_tet_springs: an edge has no spring");
      tet_springs[t][i] = s;
    }
  }
  return tet_springs;
}

VertexSprings build_vertex_springs(const SpringNetwork& network, std::size_t vertices) {
  VertexSprings rows;
  rows.offsets.assign(vertices + 1, 0);
  for (const Edge& spring : network.springs) {
    for (const Index v : spring) ++rows.offsets[v + 1];
  }
  for (std::size_t v = 1; v <= vertices; ++v) rows.offsets[v] += rows.offsets[v - 1];
  rows.springs.resize(2 * network.springs.size());
  std::vector<Index> next(rows.offsets.begin(), rows.offsets.end() - 1);
  for (Index s = 0; s < network.springs.size(); ++s) {
    for (const Index v : network.springs[s]) rows.springs[next[v]++] = s;
  }
  return rows;
}

std::vector<Vec3> build_spring_directions(const TetMesh& mesh, const SpringNetwork& network) {
  std::vector<Vec3> directions;
  directions.reserve(network.springs.size());
  for (const auto& [a, b] : network.springs) {
    const Vec3 d = mesh.points[b] - mesh.points[a];
    directions.push_back((1.0 / length(d)) * d);
  }
  return directions;
}

std::vector<double> build_stiffness_ratios(const SpringNetwork& network,
                                           std::span<const double> influence_volumes,
                                           double young_modulus_pa) {
  std::vector<double> ratios(influence_volumes.size(), 0.0);
  for (std::size_t s = 0; s < network.springs.size(); ++s) {
    const double w = network.stiffness_n_per_m[s] * network.rest_length_m[s] * network.rest_length_m[s];
    for (const Index v : network.springs[s]) ratios[v] += w;
  }
  for (std::size_t v = 0; v < ratios.size(); ++v) ratios[v] /= 12.0 * young_modulus_pa * influence_volumes[v];
  return ratios;
}

}  // namespace palpate::springs

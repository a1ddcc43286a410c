#include "core/springs/network/tet_shares.h"

#include <algorithm>

#include "core/base/error.h"
#include "core/mesh/topology.h"
#include "core/springs/network/network.h"

namespace palpate::springs {
namespace {

Index spring_between(const SpringNetwork& network, Index a, Index b) {
  const Edge pair{std::min(a, b), std::max(a, b)};
  const auto found = std::lower_bound(network.springs.begin(), network.springs.end(), pair);
  require(found != network.springs.end() && *found == pair, "TetShares: no spring between opposite apexes");
  return static_cast<Index>(found - network.springs.begin());
}

}  // namespace

TetShares::TetShares(const TetMesh& mesh, SpringNetwork& network)
    : network_(network), tet_springs_(build_tet_springs(mesh, network)) {
  std::fill(network.stiffness_n_per_m.begin(), network.stiffness_n_per_m.end(), 0.0);
  if (network.springs.size() > build_edges(mesh).size()) find_opposite(mesh);
}

void TetShares::find_opposite(const TetMesh& mesh) {
  opposite_.assign(mesh.tets.size(), {kNoIndex, kNoIndex, kNoIndex, kNoIndex});
  for (const Face& face : build_faces(mesh)) {
    if (face.tets[1] == kNoIndex) continue;
    const Index a = apex_of(mesh.tets[face.tets[0]], face.vertices);
    const Index b = apex_of(mesh.tets[face.tets[1]], face.vertices);
    if (a == b) continue;
    const Index spring = spring_between(network_, a, b);
    for (const Index tet : face.tets) {
      auto& springs = opposite_[tet];
      *std::find(springs.begin(), springs.end(), kNoIndex) = spring;
    }
  }
}

void TetShares::add(std::size_t tet, const std::array<double, 6>& stiffness_n_per_m) {
  const std::array<Index, 6>& edges = tet_springs_[tet];
  std::size_t inner = 0;
  if (!opposite_.empty()) {
    const auto& springs = opposite_[tet];
    inner = static_cast<std::size_t>(std::find(springs.begin(), springs.end(), kNoIndex) - springs.begin());
  }
  const double parts = 6.0 + static_cast<double>(inner);
  double sum = 0.0;  // of k l^2, in J
  for (std::size_t i = 0; i < 6; ++i) {
    const double l = network_.rest_length_m[edges[i]];
    sum += stiffness_n_per_m[i] * l * l;
    network_.stiffness_n_per_m[edges[i]] += 6.0 / parts * stiffness_n_per_m[i];
  }
  for (std::size_t i = 0; i < inner; ++i) {
    const Index spring = opposite_[tet][i];
    const double l = network_.rest_length_m[spring];
    network_.stiffness_n_per_m[spring] += sum / (parts * l * l);
  }
}

}  // namespace palpate::springs

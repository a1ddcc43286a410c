#include "core/simplify/fusion/levels.h"

#include <algorithm>
#include <utility>

#include "core/base/error.h"

namespace palpate::simplify {
namespace {

int count_shared(const Tet& a, const Tet& b) {
  int shared = 0;
  for (const Index v : a) shared += static_cast<int>(std::find(b.begin(), b.end(), v) != b.end());
  return shared;
}

/// Vertex adjacency: the level is the least distance, along edges, of the tet's vertices from the boundary,
/// so one sweep over vertices does.
std::vector<std::uint16_t> levels_by_vertex(const FusionMesh& mesh, std::vector<std::uint8_t> seen) {
  std::vector<std::uint16_t> level(mesh.tets.size(), kNoLevel);
  std::vector<Index> ring;
  for (Index v = 0; v < mesh.points.size(); ++v) {
    if (seen[v] != 0) ring.push_back(v);
  }
  std::vector<Index> next;
  for (std::uint16_t n = 0; !ring.empty() && n < kNoLevel; ++n) {
    next.clear();
    for (const Index v : ring) {
      for (const Index t : mesh.star(v)) {
        if (level[t] != kNoLevel) continue;
        level[t] = n;
        for (const Index w : mesh.tets[t]) {
          if (std::exchange(seen[w], 1) == 0) next.push_back(w);
        }
      }
    }
    ring.swap(next);
  }
  return level;
}

}  // namespace

std::vector<std::uint16_t> build_levels(const FusionMesh& mesh,
                                        const std::vector<std::uint8_t>& is_boundary_vertex,
                                        LevelAdjacency adjacency) {
  require(is_boundary_vertex.size() == mesh.points.size(), "build_levels: one flag a vertex");
  std::vector<std::uint8_t> on_boundary(mesh.points.size());
  for (Index v = 0; v < mesh.points.size(); ++v)
    on_boundary[v] = is_boundary_vertex[mesh.origin_of_vertex(v)];
  if (adjacency == LevelAdjacency::kVertex) return levels_by_vertex(mesh, std::move(on_boundary));
  const int least_shared = adjacency == LevelAdjacency::kEdge ? 2 : 3;
  std::vector<std::uint16_t> level(mesh.tets.size(), kNoLevel);
  std::vector<Index> ring;
  for (Index t = 0; t < mesh.tets.size(); ++t) {
    const Tet& tet = mesh.tets[t];
    if (std::any_of(tet.begin(), tet.end(), [&](Index v) { return on_boundary[v] != 0; })) {
      level[t] = 0;
      ring.push_back(t);
    }
  }
  std::vector<Index> next;
  for (std::uint16_t n = 1; !ring.empty() && n < kNoLevel; ++n) {
    next.clear();
    for (const Index t : ring) {
      for (const Index v : mesh.tets[t]) {
        for (const Index other : mesh.star(v)) {
          if (level[other] != kNoLevel || count_shared(mesh.tets[t], mesh.tets[other]) < least_shared)
            continue;
          level[other] = n;
          next.push_back(other);
        }
      }
    }
    ring.swap(next);
  }
  return level;
}

std::vector<std::uint64_t> count_levels(const std::vector<std::uint16_t>& level) {
  std::vector<std::uint64_t> sizes;
  for (const std::uint16_t n : level) {
    if (n == kNoLevel) continue;
    if (n >= sizes.size()) sizes.resize(n + 1U, 0);
    ++sizes[n];
  }
  return sizes;
}

}  // namespace palpate::simplify

#include "core/judge/mesh/tet_edges.h"

#include <algorithm>

#include "core/base/error.h"

namespace palpate::judge {
namespace {

/// One of the six sides of a tet, in the bucket of its smaller vertex.
struct Side {
  Index larger;
  std::size_t slot;  ///< 6 x tet + local edge
};

}  // namespace

TetEdges number_edges(const TetMesh& mesh) {
  const std::size_t count = mesh.points.size();
  std::vector<std::size_t> first(count + 1, 0);
  const auto ends = [&](const Tet& tet, std::size_t k) {
    const Index a = tet[kTetEdges[k][0]];
    const Index b = tet[kTetEdges[k][1]];
    return Edge{std::min(a, b), std::max(a, b)};
  };
  for (const Tet& tet : mesh.tets) {
    for (const Index v : tet) require(v < count, "number_edges: a tet has a vertex that does not exist");
    for (std::size_t k = 0; k < kTetEdges.size(); ++k) ++first[ends(tet, k)[0] + 1];
  }
  for (std::size_t v = 0; v < count; ++v) first[v + 1] += first[v];

  std::vector<Side> sides(6 * mesh.tets.size());
  std::vector<std::size_t> next(first.begin(), first.end() - 1);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    for (std::size_t k = 0; k < kTetEdges.size(); ++k) {
      const Edge edge = ends(mesh.tets[t], k);
      sides[next[edge[0]]++] = {edge[1], 6 * t + k};
    }
  }

  TetEdges found;
  found.of_tet.resize(mesh.tets.size());
  for (std::size_t v = 0; v < count; ++v) {
    const auto begin = sides.begin() + static_cast<std::ptrdiff_t>(first[v]);
    const auto end = sides.begin() + static_cast<std::ptrdiff_t>(first[v + 1]);
    std::sort(begin, end, [](const Side& s, const Side& t) { return s.larger < t.larger; });
    for (auto side = begin; side != end; ++side) {
      if (side == begin || side->larger != (side - 1)->larger)
        found.edges.push_back({static_cast<Index>(v), side->larger});
      found.of_tet[side->slot / 6][side->slot % 6] = static_cast<Index>(found.edges.size() - 1);
    }
  }
  return found;
}

}  // namespace palpate::judge

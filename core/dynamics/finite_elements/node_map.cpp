#include "core/dynamics/finite_elements/node_map.h"

#include <algorithm>
#include <utility>

#include "core/base/error.h"

namespace palpate::dynamics {
namespace {

/// Adds the row of a node that is unknown itself.
void add_own_row(Index node, NodeMap& map) {
  map.unknowns.push_back(static_cast<Index>(map.nodes.size()));
  map.weights.push_back(1.0);
  map.offsets.push_back(map.unknowns.size());
  map.nodes.push_back(node);
}

/// Adds the mean of two rows that are there.
void add_mean_row(Index a, Index b, NodeMap& map) {
  std::vector<std::pair<Index, double>> entries;
  for (const Index row : {a, b}) {
    for (std::size_t k = map.offsets[row]; k < map.offsets[row + std::size_t{1}]; ++k)
      entries.emplace_back(map.unknowns[k], 0.5 * map.weights[k]);
  }
  std::sort(entries.begin(), entries.end());
  const std::size_t first = map.unknowns.size();
  for (const auto& [unknown, weight] : entries) {
    if (map.unknowns.size() > first && map.unknowns.back() == unknown) {
      map.weights.back() += weight;
    } else {
      map.unknowns.push_back(unknown);
      map.weights.push_back(weight);
    }
  }
  map.offsets.push_back(map.unknowns.size());
}

}  // namespace

NodeMap follow_edges(const ElementSpace& space, std::span<const std::uint8_t> own) {
  require(space.order == 2 && own.size() == space.edges.edges.size(), "one flag an edge, order 2");
  const std::size_t vertices = space.nodes() - own.size();
  NodeMap map;
  for (std::size_t v = 0; v < vertices; ++v) add_own_row(static_cast<Index>(v), map);
  for (std::size_t e = 0; e < own.size(); ++e) {
    if (own[e] != 0) {
      add_own_row(static_cast<Index>(vertices + e), map);
    } else {
      add_mean_row(space.edges.edges[e][0], space.edges.edges[e][1], map);
    }
  }
  return map;
}

NodeMap embed_linear(const ElementSpace& space, std::size_t vertices, std::span<const Edge> halved) {
  require(space.order == 2 && space.nodes() == vertices + halved.size() + space.edges.edges.size(),
          "the vertices, the midpoints of halved edges, and those of the space's own");
  NodeMap map;
  for (std::size_t v = 0; v < vertices; ++v) add_own_row(static_cast<Index>(v), map);
  for (const auto& [a, b] : halved) add_mean_row(a, b, map);
  for (const auto& [a, b] : space.edges.edges) add_mean_row(a, b, map);
  return map;
}

std::vector<Vec3> apply_map(const NodeMap& map, std::span<const Vec3> u) {
  require(u.size() == map.nodes.size(), "one entry an unknown");
  std::vector<Vec3> all(map.rows());
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (std::size_t k = map.offsets[i]; k < map.offsets[i + 1]; ++k)
      all[i] = all[i] + map.weights[k] * u[map.unknowns[k]];
  }
  return all;
}

std::vector<Vec3> apply_transposed(const NodeMap& map, std::span<const Vec3> f) {
  require(f.size() == map.rows(), "one entry a node");
  std::vector<Vec3> sum(map.nodes.size());
  for (std::size_t i = 0; i < f.size(); ++i) {
    for (std::size_t k = map.offsets[i]; k < map.offsets[i + 1]; ++k)
      sum[map.unknowns[k]] = sum[map.unknowns[k]] + map.weights[k] * f[i];
  }
  return sum;
}

BlockMatrix restrict_matrix(const NodeMap& map, const ElementSpace& space, const BlockMatrix& matrix) {
  require(space.nodes() == map.rows() && matrix.rows() == map.rows(), "map, space and matrix of one size");
  const std::size_t per_tet = space.nodes_per_tet();
  std::vector<Index> offsets{0};
  std::vector<Index> members;
  std::vector<Index> here;
  for (std::size_t first = 0; first < space.tet_nodes.size(); first += per_tet) {
    here.clear();
    for (std::size_t n = first; n < first + per_tet; ++n) {
      const Index node = space.tet_nodes[n];
      for (std::size_t k = map.offsets[node]; k < map.offsets[node + std::size_t{1}]; ++k)
        here.push_back(map.unknowns[k]);
    }
    std::sort(here.begin(), here.end());
    here.erase(std::unique(here.begin(), here.end()), here.end());
    members.insert(members.end(), here.begin(), here.end());
    offsets.push_back(static_cast<Index>(members.size()));
  }
  const VertexGroups groups{offsets, members};
  BlockMatrix out = build_block_matrix(map.nodes.size(), {&groups, 1});
  for (std::size_t i = 0; i < matrix.rows(); ++i) {
    for (std::size_t place = matrix.offsets[i]; place < matrix.offsets[i + 1]; ++place) {
      const std::size_t j = matrix.columns[place];
      for (std::size_t a = map.offsets[i]; a < map.offsets[i + 1]; ++a) {
        for (std::size_t b = map.offsets[j]; b < map.offsets[j + 1]; ++b)
          add_block(out, map.unknowns[a], map.unknowns[b],
                    (map.weights[a] * map.weights[b]) * matrix.blocks[place]);
      }
    }
  }
  return out;
}

std::vector<std::uint8_t> find_touched(std::size_t vertices, const BoundaryProblem& problem) {
  std::vector<std::uint8_t> touched(vertices, 0);
  const auto mark = [&](const std::vector<Triangle>& faces) {
    for (const Triangle& face : faces) {
      for (const Index v : face) touched.at(v) = 1;
    }
  };
  for (const HeldFaces& held : problem.held) mark(held.faces);
  for (const ElasticSupport& support : problem.supports) mark(support.patch.faces);
  for (const Traction& traction : problem.tractions) mark(traction.patch.faces);
  for (const NodalForce& force : problem.nodal_forces) touched.at(force.vertex) = 1;
  return touched;
}

std::vector<std::uint8_t> find_edges_near(const EdgeNumbers& edges, std::span<const std::uint8_t> touched,
                                          int rings) {
  std::vector<std::uint8_t> flags(edges.edges.size(), 0);
  if (rings < 0) return flags;
  std::vector<std::uint8_t> near(touched.begin(), touched.end());
  for (int ring = 0; ring < rings; ++ring) {
    const std::vector<std::uint8_t> before = near;
    for (const auto& [a, b] : edges.edges) {
      if (before[a] != 0) near[b] = 1;
      if (before[b] != 0) near[a] = 1;
    }
    if (near == before) break;
  }
  for (std::size_t e = 0; e < flags.size(); ++e)
    flags[e] = near[edges.edges[e][0]] != 0 && near[edges.edges[e][1]] != 0 ? 1 : 0;
  return flags;
}

}  // namespace palpate::dynamics

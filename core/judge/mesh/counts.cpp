#include <algorithm>

#include "core/judge/mesh/judge.h"
#include "core/judge/mesh/vertex_links.h"

namespace palpate::judge {
namespace {

/// V - 3 <= T <= C(V - 1, 2) - n + 2 with n boundary vertices (n at least 4).
bool within_tet_bounds(const Counts& counts) {
  const std::uint64_t v = counts.vertices;
  if (v < 4) return false;
  const std::uint64_t pairs = v % 2 == 1 ? (v - 1) / 2 * (v - 2) : (v - 2) / 2 * (v - 1);
  const std::uint64_t n = std::max<std::uint64_t>(counts.boundary_vertices, 4);
  return v <= counts.tets + 3 && counts.tets + n <= pairs + 2;
}

std::int64_t alternating_sum(std::uint64_t vertices, std::uint64_t edges, std::uint64_t faces,
                             std::uint64_t tets) {
  return static_cast<std::int64_t>(vertices) - static_cast<std::int64_t>(edges) +
         static_cast<std::int64_t>(faces) - static_cast<std::int64_t>(tets);
}

/// Counts what lies at one vertex after another; faces and edges are counted from their least vertex.
class Counting {
 public:
  Counting(const TetMesh& mesh, const Stars& stars)
      : link_(mesh, stars), at_rim_(mesh.points.size(), kNoIndex) {
    tet_sets_.reset(mesh.tets.size());
    boundary_sets_.reset(mesh.points.size());
    counts_.tets = stars.tets.size() / 4;
    counts_.components = counts_.tets;
  }

  void add_vertex(Index vertex) {
    link_.move_to(vertex);
    if (link_.triangles() == 0) return;
    ++counts_.vertices;
    for (const Index other : link_.vertices()) {
      if (vertex < other) ++counts_.edges;
    }
    bool on_boundary = false;
    link_.for_each_face([&](LinkFace face) {
      const Index low = face[0].low;
      const Index high = face[0].high;
      const bool is_boundary = face.size() == 1;
      if (is_boundary) {
        on_boundary = true;
        add_rim_edge(low);
        add_rim_edge(high);
      }
      if (vertex > low) return;
      ++counts_.faces;
      if (is_boundary) {
        ++counts_.boundary_faces;
        joined_boundary_ += boundary_sets_.join(vertex, low) ? 1 : 0;
        joined_boundary_ += boundary_sets_.join(vertex, high) ? 1 : 0;
      }
      for (std::size_t i = 1; i < face.size(); ++i) {
        if (tet_sets_.join(face[0].tet, face[i].tet)) --counts_.components;
      }
    });
    if (on_boundary) ++counts_.boundary_vertices;
  }

  Counts finish() {
    Counts& c = counts_;
    c.boundary_components = c.boundary_vertices - joined_boundary_;
    c.euler = alternating_sum(c.vertices, c.edges, c.faces, c.tets);
    c.boundary_euler = alternating_sum(c.boundary_vertices, c.boundary_edges, c.boundary_faces, 0);
    c.euler_consistent = c.boundary_euler == 2 * c.euler;
    c.formula_a1 = c.boundary_components == 1 && c.boundary_euler == 2;
    c.formula_a2 = c.euler == 1;
    c.formula_a3 = within_tet_bounds(c);
    return c;
  }

 private:
  /// Counts the boundary edge from the present vertex to `other`, once.
  void add_rim_edge(Index other) {
    if (other < link_.vertex() || at_rim_[other] == link_.vertex()) return;
    at_rim_[other] = link_.vertex();
    ++counts_.boundary_edges;
  }

  VertexLink link_;
  Counts counts_;
  DisjointSets tet_sets_;
  DisjointSets boundary_sets_;
  std::uint64_t joined_boundary_ = 0;
  std::vector<Index> at_rim_;  // one a vertex: the last vertex from which a boundary edge to it was counted
};

}  // namespace

Counts count_elements(const TetMesh& mesh) {
  const Stars stars = build_stars(mesh);
  Counting counting(mesh, stars);
  for (std::size_t v = 0; v < mesh.points.size(); ++v) counting.add_vertex(static_cast<Index>(v));
  return counting.finish();
}

}  // namespace palpate::judge

#include "core/simplify/skin_guard/input_skin.h"

#include <algorithm>
#include <utility>

namespace palpate::simplify {
namespace {

std::vector<BoxedTriangle> collect_triangles(const WorkingMesh& mesh, const std::vector<Triangle>& faces) {
  std::vector<BoxedTriangle> triangles;
  triangles.reserve(faces.size());
  for (const Triangle& t : faces)
    triangles.emplace_back(TriangleCorners{mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]]});
  return triangles;
}

std::vector<std::array<Index, 3>> find_neighbours(const std::vector<Triangle>& faces) {
  struct Edge {
    std::pair<Index, Index> ends;
    Index face;
  };
  std::vector<Edge> edges;
  edges.reserve(3 * faces.size());
  for (Index f = 0; f < faces.size(); ++f) {
    for (std::size_t k = 0; k < 3; ++k) edges.push_back({{faces[f][k], faces[f][(k + 1) % 3]}, f});
  }
  const auto comes_before = [](const Edge& a, const Edge& b) { return a.ends < b.ends; };
  std::sort(edges.begin(), edges.end(), comes_before);
  const auto across = [&](Index from, Index to) {
    const Edge turned{{to, from}, kNoIndex};
    const auto found = std::lower_bound(edges.begin(), edges.end(), turned, comes_before);
    return found != edges.end() && found->ends == turned.ends ? found->face : kNoIndex;
  };
  std::vector<std::array<Index, 3>> neighbours;
  neighbours.reserve(faces.size());
  for (const Triangle& t : faces)
    neighbours.push_back({across(t[0], t[1]), across(t[1], t[2]), across(t[2], t[0])});
  return neighbours;
}

}  // namespace

InputSkin::InputSkin(const WorkingMesh& mesh, const std::vector<Triangle>& faces)
    : faces_(faces),
      triangles_(collect_triangles(mesh, faces)),
      neighbours_(find_neighbours(faces)),
      tree_(mesh.points, faces) {}

double InputSkin::mean_edge() const {
  double sum = 0.0;
  for (const BoxedTriangle& triangle : triangles_) {
    const TriangleCorners& t = triangle.corner;
    sum += length(t[1] - t[0]) + length(t[2] - t[1]) + length(t[0] - t[2]);
  }
  return sum / (3.0 * static_cast<double>(std::max<std::size_t>(1, faces_.size())));
}

}  // namespace palpate::simplify

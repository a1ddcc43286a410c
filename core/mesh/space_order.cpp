#include "core/mesh/space_order.h"

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <utility>

#include "core/base/parallel.h"
#include "core/mesh/geometry.h"

namespace palpate {
namespace {

/// Spreads the low 21 bits of `x` to every third bit.
std::uint64_t spread_bits(std::uint64_t x) {
  x &= 0x1fffffU;
  x = (x | x << 32U) & 0x1f00000000ffffULL;
  x = (x | x << 16U) & 0x1f0000ff0000ffULL;
  x = (x | x << 8U) & 0x100f00f00f00f00fULL;
  x = (x | x << 4U) & 0x10c30c30c30c30c3ULL;
  x = (x | x << 2U) & 0x1249249249249249ULL;
  return x;
}

}  // namespace

std::vector<Index> order_in_space(std::span<const Vec3> points, int threads) {
  const BoundingBox box = bounding_box(points);
  const double longest = longest_side(box);
  const double scale = longest > 0.0 ? 2097151.0 / longest : 0.0;
  struct Entry {
    std::uint64_t key;
    Index vertex;
  };
  std::vector<Entry> entries(points.size());
  for_ranges(points.size(), threads, [&](std::size_t first, std::size_t last, std::size_t) {
    for (std::size_t v = first; v < last; ++v) {
      const Vec3 p = scale * (points[v] - box.low);
      entries[v] = {spread_bits(static_cast<std::uint64_t>(p.x)) |
                        spread_bits(static_cast<std::uint64_t>(p.y)) << 1U |
                        spread_bits(static_cast<std::uint64_t>(p.z)) << 2U,
                    static_cast<Index>(v)};
    }
  });
  sort_on_threads(entries, threads, [](const Entry& a, const Entry& b) {
    return a.key != b.key ? a.key < b.key : a.vertex < b.vertex;
  });
  std::vector<Index> order(points.size());
  std::transform(entries.begin(), entries.end(), order.begin(), [](const Entry& e) { return e.vertex; });
  return order;
}

// Renumbers vertices along the curve, then tets by their smallest new vertex (a counting sort, so stable).
MeshOrigin sort_in_space(TetMesh& mesh, int threads) {
  MeshOrigin result;
  result.vertices = order_in_space(mesh.points, threads);
  std::vector<Index> new_number(mesh.points.size());
  std::vector<Vec3> points(mesh.points.size());
  for_ranges(points.size(), threads, [&](std::size_t first, std::size_t last, std::size_t) {
    for (std::size_t v = first; v < last; ++v) {
      new_number[result.vertices[v]] = static_cast<Index>(v);
      points[v] = mesh.points[result.vertices[v]];
    }
  });
  mesh.points = std::move(points);
  for_ranges(mesh.tets.size(), threads, [&](std::size_t first, std::size_t last, std::size_t) {
    for (std::size_t t = first; t < last; ++t) {
      for (Index& v : mesh.tets[t]) v = new_number[v];
    }
  });
  const auto first_vertex = [](const Tet& t) { return std::min({t[0], t[1], t[2], t[3]}); };
  std::vector<Index>& begin = new_number;  // its memory serves as the rows' cursors
  begin.assign(mesh.points.size() + 1, 0);
  for (const Tet& tet : mesh.tets) ++begin[first_vertex(tet) + 1];
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  result.tets.resize(mesh.tets.size());
  for (Index t = 0; t < mesh.tets.size(); ++t) result.tets[begin[first_vertex(mesh.tets[t])]++] = t;
  std::vector<Tet> tets(mesh.tets.size());
  for_ranges(tets.size(), threads, [&](std::size_t first, std::size_t last, std::size_t) {
    for (std::size_t t = first; t < last; ++t) tets[t] = mesh.tets[result.tets[t]];
  });
  mesh.tets = std::move(tets);
  return result;
}

}  // namespace palpate

#include "core/dynamics/plain_layout.h"

#include <algorithm>
#include <cstdint>
#include <numeric>

#include "core/mesh/geometry.h"

namespace palpate::dynamics {
namespace {

/// Spreads 21 bits so that two zeros follow each.
std::uint64_t spread_bits(std::uint64_t x) {
  x &= 0x1fffffULL;
  x = (x | (x << 32U)) & 0x1f00000000ffffULL;
  x = (x | (x << 16U)) & 0x1f0000ff0000ffULL;
  x = (x | (x << 8U)) & 0x100f00f00f00f00fULL;
  x = (x | (x << 4U)) & 0x10c30c30c30c30c3ULL;
  return (x | (x << 2U)) & 0x1249249249249249ULL;
}

/// Puts item i n / 8 + k, i < 8, at place 8 k + i.
void deal_out(std::vector<Index>& list) {
  const std::size_t rows = (list.size() + 7) / 8;
  std::vector<Index> out;
  out.reserve(list.size());
  for (std::size_t k = 0; k < rows; ++k) {
    for (std::size_t i = 0; i < 8; ++i) {
      if (i * rows + k < list.size()) out.push_back(list[i * rows + k]);
    }
  }
  list = std::move(out);
}

}  // namespace

std::vector<Index> order_along_morton_curve(std::span<const Vec3> points) {
  const BoundingBox box = bounding_box(points);
  const Vec3 size = box.high - box.low;
  const double longest = std::max({size.x, size.y, size.z});
  const double scale = longest > 0.0 ? 2097151.0 / longest : 0.0;
  std::vector<std::uint64_t> key(points.size());
  for (std::size_t v = 0; v < points.size(); ++v) {
    const Vec3 at = scale * (points[v] - box.low);
    key[v] = spread_bits(static_cast<std::uint64_t>(at.x)) |
             (spread_bits(static_cast<std::uint64_t>(at.y)) << 1U) |
             (spread_bits(static_cast<std::uint64_t>(at.z)) << 2U);
  }
  std::vector<Index> order(points.size());
  std::iota(order.begin(), order.end(), Index{0});
  std::sort(order.begin(), order.end(),
            [&](Index a, Index b) { return key[a] != key[b] ? key[a] < key[b] : a < b; });
  return order;
}

SpringBlocks build_spring_blocks(std::span<const Edge> springs, std::span<const Index> place,
                                 std::size_t block_vertices) {
  const std::size_t blocks = (place.size() + block_vertices - 1) / block_vertices;
  SpringBlocks out{block_vertices, std::vector<std::vector<Index>>(blocks),
                   std::vector<std::vector<Index>>(blocks)};
  for (std::size_t s = 0; s < springs.size(); ++s) {
    const std::size_t a = place[springs[s][0]] / block_vertices;
    const std::size_t b = place[springs[s][1]] / block_vertices;
    if (a == b) {
      out.inside[a].push_back(static_cast<Index>(s));
    } else {
      out.across[a].push_back(static_cast<Index>(s));
      out.across[b].push_back(static_cast<Index>(s));
    }
  }
  const auto ends = [&](Index s, std::size_t block) {
    Index first = place[springs[s][0]];
    Index second = place[springs[s][1]];
    const bool is_first_here = first / block_vertices == block;
    const bool is_second_here = second / block_vertices == block;
    if (is_first_here == is_second_here ? second < first : is_second_here) std::swap(first, second);
    return std::pair{first, second};
  };
  for (std::size_t b = 0; b < blocks; ++b) {
    for (std::vector<Index>* list : {&out.inside[b], &out.across[b]}) {
      std::sort(list->begin(), list->end(), [&](Index s, Index t) { return ends(s, b) < ends(t, b); });
      deal_out(*list);
    }
  }
  return out;
}

}  // namespace palpate::dynamics

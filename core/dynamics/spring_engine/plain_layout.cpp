#include "core/dynamics/spring_engine/plain_layout.h"

#include <algorithm>
#include <utility>

namespace palpate::dynamics {
namespace {

/// Puts item i n / 8 + k, i < 8, at place 8 k + i.
template <typename Item>
void deal_out(std::vector<Item>& list) {
  const std::size_t rows = (list.size() + 7) / 8;
  std::vector<Item> out;
  out.reserve(list.size());
  for (std::size_t k = 0; k < rows; ++k) {
    for (std::size_t i = 0; i < 8; ++i) {
      if (i * rows + k < list.size()) out.push_back(list[i * rows + k]);
    }
  }
  list = std::move(out);
}

/// The ends of a spring as places: first the one in the block, of two such the earlier.
std::pair<Index, Index> find_ends(const Edge& spring, std::span<const Index> place, std::size_t block,
                                  std::size_t block_vertices) {
  Index first = place[spring[0]];
  Index second = place[spring[1]];
  const bool is_first_here = first / block_vertices == block;
  const bool is_second_here = second / block_vertices == block;
  if (is_first_here == is_second_here ? second < first : is_second_here) std::swap(first, second);
  return {first, second};
}

/// A spring and the later of its ends, as a place.
struct Later {
  Index end;
  Index spring;
};

/// The fans of a block. `sorted` holds its springs by their places.
std::vector<SpringFan> build_fans(const std::vector<Index>& sorted, std::span<const Edge> springs,
                                  std::span<const Index> place, std::size_t block,
                                  std::size_t block_vertices) {
  const std::size_t first_place = block * block_vertices;
  std::vector<std::vector<Index>> left(block_vertices);  // to a vertex, by earlier ones
  std::vector<SpringFan> fans;
  std::vector<Later> later;
  const auto finish = [&](Index at) {
    std::vector<Index>& own = left[at - first_place];
    const std::size_t rest = std::min((own.size() + later.size()) % 4, later.size());
    for (std::size_t k = 0; k < later.size(); ++k) {
      (k < rest ? left[later[k].end - first_place] : own).push_back(later[k].spring);
    }
    for (std::size_t k = 0; k < own.size(); ++k) {
      if (k % 4 == 0) {
        const Edge& ends = springs[own[k]];
        fans.push_back({place[ends[0]] == at ? ends[0] : ends[1], {kNoIndex, kNoIndex, kNoIndex, kNoIndex}});
      }
      fans.back().springs[k % 4] = own[k];
    }
    later.clear();
  };
  std::size_t next = 0;
  for (std::size_t v = 0; v < block_vertices; ++v) {
    const auto at = static_cast<Index>(first_place + v);
    for (; next < sorted.size(); ++next) {
      const auto [first, second] = find_ends(springs[sorted[next]], place, block, block_vertices);
      if (first != at) break;
      later.push_back({second, sorted[next]});
    }
    finish(at);
  }
  return fans;
}

}  // namespace

SpringBlocks build_spring_blocks(std::span<const Edge> springs, std::span<const Index> place,
                                 std::size_t block_vertices) {
  const std::size_t blocks = (place.size() + block_vertices - 1) / block_vertices;
  std::vector<std::vector<Index>> inside(blocks);
  SpringBlocks out{block_vertices, {}, std::vector<std::vector<Index>>(blocks)};
  for (std::size_t s = 0; s < springs.size(); ++s) {
    const std::size_t a = place[springs[s][0]] / block_vertices;
    const std::size_t b = place[springs[s][1]] / block_vertices;
    if (a == b) {
      inside[a].push_back(static_cast<Index>(s));
    } else {
      out.across[a].push_back(static_cast<Index>(s));
      out.across[b].push_back(static_cast<Index>(s));
    }
  }
  for (std::size_t b = 0; b < blocks; ++b) {
    for (std::vector<Index>* list : {&inside[b], &out.across[b]}) {
      std::sort(list->begin(), list->end(), [&](Index s, Index t) {
        return find_ends(springs[s], place, b, block_vertices) <
               find_ends(springs[t], place, b, block_vertices);
      });
    }
    out.inside.push_back(build_fans(inside[b], springs, place, b, block_vertices));
    deal_out(out.inside[b]);
    deal_out(out.across[b]);
  }
  return out;
}

}  // namespace palpate::dynamics

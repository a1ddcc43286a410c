#include "core/dynamics/tet_engine/domain_layout.h"

#include <algorithm>
#include <tuple>
#include <utility>

#include "core/dynamics/tet_engine/domain_kernel.h"

namespace palpate::dynamics {
namespace {

/// The block that has most of the vertices.
std::size_t find_block(std::span<const Index> vertices, std::span<const Index> place,
                       std::size_t block_vertices) {
  std::vector<std::size_t> blocks;
  blocks.reserve(vertices.size());
  for (const Index v : vertices) blocks.push_back(place[v] / block_vertices);
  std::sort(blocks.begin(), blocks.end());
  std::size_t best = blocks.front();
  std::ptrdiff_t most = 0;
  for (auto first = blocks.begin(); first != blocks.end();) {
    const auto last = std::upper_bound(first, blocks.end(), *first);
    if (last - first > most) {
      most = last - first;
      best = *first;
    }
    first = last;
  }
  return best;
}

/// Puts item i n / 8 + k, i < 8, at place 8 k + i.
void deal_out(std::vector<Index>& list) {
  const std::size_t rows = (list.size() + kGroupDomains - 1) / kGroupDomains;
  std::vector<Index> out;
  out.reserve(list.size());
  for (std::size_t k = 0; k < rows; ++k) {
    for (std::size_t i = 0; i < kGroupDomains; ++i) {
      if (i * rows + k < list.size()) out.push_back(list[i * rows + k]);
    }
  }
  list = std::move(out);
}

/// Groups of eight by number of vertices; those of one class in curve order, then dealt out.
std::vector<DomainClass> build_classes(const StrainOperator& op, const std::vector<Index>& domains,
                                       std::span<const Index> place) {
  const auto first_place = [&](Index s) {
    Index first = kNoIndex;
    for (const Index v : op.vertices_of(s)) first = std::min(first, place[v]);
    return first;
  };
  std::vector<std::tuple<std::size_t, Index, Index>> keyed;
  keyed.reserve(domains.size());
  for (const Index s : domains) keyed.emplace_back(op.vertices_of(s).size(), first_place(s), s);
  std::sort(keyed.begin(), keyed.end());
  std::vector<DomainClass> classes;
  std::vector<std::vector<std::pair<Index, Index>>> members;
  for (std::size_t first = 0; first < keyed.size(); first += kGroupDomains) {
    const std::size_t last = std::min(first + kGroupDomains, keyed.size());
    const std::size_t vertices = std::get<0>(keyed[last - 1]);
    if (classes.empty() || classes.back().vertices != vertices) {
      classes.push_back({vertices, {}});
      members.emplace_back();
    }
    for (std::size_t k = first; k < last; ++k)
      members.back().emplace_back(std::get<1>(keyed[k]), std::get<2>(keyed[k]));
  }
  for (std::size_t c = 0; c < classes.size(); ++c) {
    std::sort(members[c].begin(), members[c].end());
    for (const auto& [at, s] : members[c]) classes[c].domains.push_back(s);
    deal_out(classes[c].domains);
  }
  return classes;
}

}  // namespace

DomainBlocks build_domain_blocks(std::span<const StrainTerm> terms, std::span<const Index> place,
                                 std::size_t block_vertices) {
  DomainBlocks out{block_vertices, {}};
  out.blocks.resize((place.size() + block_vertices - 1) / block_vertices);
  for (const StrainTerm& term : terms) {
    std::vector<std::vector<Index>> own(out.blocks.size());
    for (std::size_t s = 0; s < term.op.domains(); ++s) {
      const std::span<const Index> vertices = term.op.vertices_of(s);
      if (vertices.empty()) continue;
      const std::size_t b = find_block(vertices, place, block_vertices);
      own[b].push_back(static_cast<Index>(s));
      for (const Index v : vertices) {
        if (place[v] / block_vertices != b) out.blocks[b].halo.push_back(place[v]);
      }
    }
    for (std::size_t b = 0; b < own.size(); ++b)
      out.blocks[b].terms.push_back(build_classes(term.op, own[b], place));
  }
  for (DomainBlock& block : out.blocks) {
    std::sort(block.halo.begin(), block.halo.end());
    block.halo.erase(std::unique(block.halo.begin(), block.halo.end()), block.halo.end());
  }
  return out;
}

}  // namespace palpate::dynamics

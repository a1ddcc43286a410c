#include "core/dynamics/tet_engine/domain_packing.h"

#include <algorithm>
#include <string>

#include "core/base/error.h"
#include "core/dynamics/tet_engine/domain_layout.h"

namespace palpate::dynamics {
namespace {

/// Where a block has the vertex at place k.
std::size_t row_of(const PackedBlock& block, Index k) {
  if (k >= block.first && k < block.first + block.count) return k - block.first;
  const auto found = std::lower_bound(block.halo.begin(), block.halo.end(), k);
  return block.count + static_cast<std::size_t>(found - block.halo.begin());
}

/// Eight domains of at most n vertices from `first` on, behind what is packed.
template <typename Real>
void pack_group(const StrainOperator& op, const DomainClass& each, std::size_t first,
                std::span<const Index> place, const PackedBlock& block, PackedDomains<Real>& out) {
  const std::size_t n = each.vertices;
  const std::size_t values = out.values.size();
  const std::size_t at = out.at.size();
  out.values.resize(values + group_values(n));
  out.at.resize(at + kGroupDomains * n);
  for (std::size_t lane = 0; lane < kGroupDomains; ++lane) {
    const bool is_there = first + lane < each.domains.size();
    const Index s = each.domains[is_there ? first + lane : first];
    const std::span<const Index> vertices = op.vertices_of(s);
    if (is_there) out.values[values + lane] = static_cast<Real>(op.volume_m3[s]);
    for (std::size_t k = 0; k < n; ++k) {
      const bool is_vertex = k < vertices.size();
      const std::size_t row = row_of(block, place[vertices[is_vertex ? k : 0]]);
      out.at[at + kGroupDomains * k + lane] = static_cast<std::uint16_t>(4 * row);
      if (k == 0 || !is_vertex) continue;
      const Vec3& gradient = op.gradients_of(s)[k];
      Real* const g = out.values.data() + values + kGroupDomains * (3 * k - 2) + lane;
      g[0] = static_cast<Real>(gradient.x);
      g[kGroupDomains] = static_cast<Real>(gradient.y);
      g[2 * kGroupDomains] = static_cast<Real>(gradient.z);
    }
  }
}

/// Tells each block what others leave for it.
void connect(std::size_t block_vertices, std::vector<PackedBlock>& blocks) {
  for (const PackedBlock& from : blocks) {
    for (std::size_t i = 0; i < from.halo.size(); ++i) {
      PackedBlock& to = blocks[from.halo[i] / block_vertices];
      to.incoming.push_back({static_cast<Index>(from.halo[i] - to.first), from.first_row + from.count + i});
    }
  }
  for (PackedBlock& block : blocks)
    std::stable_sort(block.incoming.begin(), block.incoming.end(),
                     [](const IncomingRow& a, const IncomingRow& b) { return a.to < b.to; });
}

}  // namespace

template <typename Real>
PackedDomains<Real> pack_domains(std::span<const StrainTerm> terms, std::span<const Index> place,
                                 std::size_t block_vertices) {
  const DomainBlocks layout = build_domain_blocks(terms, place, block_vertices);
  PackedDomains<Real> out;
  for (std::size_t b = 0; b < layout.blocks.size(); ++b) {
    const DomainBlock& from = layout.blocks[b];
    PackedBlock& block = out.blocks.emplace_back();
    block.first = b * block_vertices;
    block.count = std::min(block_vertices, place.size() - block.first);
    block.first_row = out.rows;
    block.halo = from.halo;
    out.rows += block.rows();
    if (block.rows() > kMostBlockRows)
      throw InputError("tet engine", 0,
                       "at most " + std::to_string(kMostBlockRows) + " vertices around a block",
                       std::to_string(block.rows()));
    for (std::size_t t = 0; t < from.terms.size(); ++t) {
      for (const DomainClass& each : from.terms[t]) {
        const std::size_t groups = (each.domains.size() + kGroupDomains - 1) / kGroupDomains;
        block.runs.push_back({t, each.vertices, groups, out.values.size(), out.at.size()});
        for (std::size_t first = 0; first < each.domains.size(); first += kGroupDomains)
          pack_group(terms[t].op, each, first, place, block, out);
      }
    }
  }
  connect(block_vertices, out.blocks);
  return out;
}

template PackedDomains<float> pack_domains(std::span<const StrainTerm>, std::span<const Index>, std::size_t);
template PackedDomains<double> pack_domains(std::span<const StrainTerm>, std::span<const Index>, std::size_t);

}  // namespace palpate::dynamics

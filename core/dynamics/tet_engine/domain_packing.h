// Domains as the kernel reads them: a pass of its own between layout and steps.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/large_pages.h"
#include "core/dynamics/elasticity/elastic_model.h"
#include "core/dynamics/tet_engine/domain_kernel.h"

namespace palpate::dynamics {

/// Groups of one class of one term: where they begin.
struct PackedRun {
  std::size_t term = 0;
  std::size_t vertices = 0;
  std::size_t groups = 0;
  std::size_t values = 0;
  std::size_t at = 0;
};

/// A row that another block leaves for a vertex of this one.
struct IncomingRow {
  Index to = 0;          ///< from the block's first vertex
  std::size_t from = 0;  ///< among all rows
};

/// A block's vertices and domains.
///
/// Shape:  its rows begin at `first_row`: first those of its own `count` vertices, from place `first` on,
/// then
///         those of its halo (core/dynamics/tet_engine/domain_layout.h). incoming is sorted by vertex, then
///         by the block that it comes from.
struct PackedBlock {
  std::size_t first = 0;
  std::size_t count = 0;
  std::size_t first_row = 0;
  std::vector<Index> halo;
  std::vector<PackedRun> runs;
  std::vector<IncomingRow> incoming;

  std::size_t rows() const { return count + halo.size(); }
};

/// All blocks; values and places as DomainRun has them.
template <typename Real>
struct PackedDomains {
  std::vector<PackedBlock> blocks;
  LargeVector<Real> values;
  LargeVector<std::uint16_t> at;
  std::size_t rows = 0;  ///< of all blocks
};

/// `place[v]` is where vertex v comes. Throws: InputError where a block's domains have more vertices than
/// kMostBlockRows.
template <typename Real>
PackedDomains<Real> pack_domains(std::span<const StrainTerm> terms, std::span<const Index> place,
                                 std::size_t block_vertices);

/// Compiled once, in domain_packing.cpp.
extern template PackedDomains<float> pack_domains(std::span<const StrainTerm>, std::span<const Index>,
                                                  std::size_t);
/// Compiled once, in domain_packing.cpp.
extern template PackedDomains<double> pack_domains(std::span<const StrainTerm>, std::span<const Index>,
                                                   std::size_t);

}  // namespace palpate::dynamics

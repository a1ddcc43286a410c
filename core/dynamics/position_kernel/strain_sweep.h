// Domains of strain of XPBD packed by colour.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/large_pages.h"
#include "core/dynamics/elasticity/elastic_model.h"
#include "core/dynamics/position_kernel/position_rows.h"
#include "core/dynamics/position_kernel/strain_kernel.h"

namespace palpate::dynamics {

/// Whether a term's moduli have a square root: mu and 2 mu + 3 lambda of zero or more.
bool can_sweep_in_lanes(const StrainTerm& term);

/// Domains of a term packed by colour: groups of eight of one colour.
class StrainSweep {
 public:
  /// Of the domains `chosen`, by the `colours` of their places there. `term` must outlive this. Requires:
  /// can_sweep_in_lanes(term).
  StrainSweep(const StrainTerm& term, std::size_t vertex_count, std::span<const Index> chosen,
              std::span<const std::vector<Index>> colours);

  /// What depends on the length of the step. `rows` have the inverse masses.
  void prepare(double step_s, double damping_s, const PositionRows& rows);
  void sweep(const SweptRows& rows, const SweepOrder& order, bool with_avx2);

 private:
  void pack(std::span<const Index> domains, std::uint32_t padding);

  const StrainTerm* term_;
  StrainStep step_;
  std::vector<StrainGroup> groups_;
  std::vector<Index> domain_of_lane_;  ///< or kNoIndex
  LargeVector<double> values_;
  LargeVector<std::uint32_t> at_;
  LargeVector<double> weights_;
  LargeVector<double> kept_;
};

}  // namespace palpate::dynamics

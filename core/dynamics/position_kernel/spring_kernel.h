// Springs of XPBD, eight at a time: one form for every processor and one for those with AVX2, with the same
// bits.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/dynamics/position_kernel/position_rows.h"
#include "core/dynamics/tet_engine/domain_kernel.h"

namespace palpate::dynamics {

/// What eight springs are made of, lane by lane. Of a linearised spring `rest` is its direction, and what
/// does not matter is zero.
struct SpringGroup {
  using Lane = std::array<double, kGroupDomains>;
  std::array<Lane, 3> rest{};  ///< the edge in the mesh, in m
  Lane length_m{};             ///< at which it does not pull
  Lane preload_m2{};           ///< |rest|^2 - length^2
  Lane stiffness{};            ///< h^2 k
  Lane damping{};              ///< h c
  Lane multiplier{};
  std::array<std::uint32_t, 2 * kGroupDomains> at{};  ///< kRowNumbers x the row of the ends a, then b
};

/// Springs of a sweep.
struct SpringRun {
  std::span<SpringGroup> groups;
  bool is_linear = false;
  bool is_damped = false;
};

/// Solves springs a--b for their own multipliers l, group after group (from the last to the first where the
/// sweep is backward):
///
///   dl = -(l + h^2 k (|d| - L) + h c n . (m - m_before)) / (1 + (h^2 k + h c) n . (w_a n + w_b n)),
///   u_a -= dl w_a n,  u_b += dl w_b n,   m = u_b - u_a,  d = rest + m,  n = d / |d|
///
/// or n = the direction at rest and n . m for |d| - L of linearised ones. A spring of length zero has no
/// direction: its dl is zero. Requires: no vertex twice in a group.
void sweep_springs(const SpringRun& run, const SweptRows& rows, const SweepOrder& order);

/// The same with AVX2. Requires: has_avx2() (core/base/processor.h).
void sweep_springs_avx2(const SpringRun& run, const SweptRows& rows, const SweepOrder& order);

}  // namespace palpate::dynamics

// The body of both forms of sweep_springs, compiled for the instruction set of who includes it
// (core/dynamics/tet_engine/matrix_lanes.h).
#pragma once

#include <cstddef>

#include "core/dynamics/position_kernel/spring_kernel.h"
#include "core/dynamics/tet_engine/matrix_lanes.h"

namespace palpate::dynamics {

/// What a spring has moved: b - a of the rows.
template <typename Eight>
PALPATE_LANES Vec3Lanes<Eight> subtract_lanes(const Vec3Lanes<Eight>& b, const Vec3Lanes<Eight>& a) {
  return {b.x - a.x, b.y - a.y, b.z - a.z};
}

/// a . b.
template <typename Eight>
PALPATE_LANES Eight dot_lanes(const Vec3Lanes<Eight>& a, const Vec3Lanes<Eight>& b) {
  return dot_lanes(a.x, b.x, a.y, b.y, a.z, b.z);
}

/// Adds s w n to the vectors of `to`, w its fourth number.
template <typename Eight>
PALPATE_LANES RowLanes<Eight> pulled_lanes(const RowLanes<Eight>& to, const Eight& s,
                                           const Vec3Lanes<Eight>& pull) {
  return {{to.xyz.x + s * pull.x, to.xyz.y + s * pull.y, to.xyz.z + s * pull.z}, to.w};
}

/// One group.
template <typename Eight, bool kLinear, bool kDamped>
PALPATE_LANES void sweep_group(SpringGroup& group, const SweptRows& rows, const SweepOrder& order) {
  const Eight one = Eight::of(1.0);
  // Below this a length is zero: no spring is that short.
  const Eight tiny = Eight::of(1e-200);
  const std::uint32_t* const at_a = group.at.data();
  const std::uint32_t* const at_b = at_a + kGroupDomains;
  const RowLanes<Eight> a = Eight::load_whole_rows(rows.now, at_a);
  const RowLanes<Eight> b = Eight::load_whole_rows(rows.now, at_b);
  const Vec3Lanes<Eight> moved = subtract_lanes(b.xyz, a.xyz);
  const Vec3Lanes<Eight> rest{Eight::load(group.rest[0].data()), Eight::load(group.rest[1].data()),
                              Eight::load(group.rest[2].data())};
  Vec3Lanes<Eight> n = rest;
  Eight elongation;
  Eight has_direction = one;
  if constexpr (kLinear) {
    elongation = dot_lanes(n, moved);
  } else {
    const Vec3Lanes<Eight> edge{rest.x + moved.x, rest.y + moved.y, rest.z + moved.z};
    const Eight size = sqrt(dot_lanes(edge, edge));
    const Eight inverse = one / max(size, tiny);
    has_direction = min(size * Eight::of(1e200), one);
    n = {inverse * edge.x, inverse * edge.y, inverse * edge.z};
    const Eight both = max(size + Eight::load(group.length_m.data()), tiny);
    elongation = ((Eight::of(2.0) * dot_lanes(rest, moved) + dot_lanes(moved, moved)) +
                  Eight::load(group.preload_m2.data())) /
                 both;
  }
  const Vec3Lanes<Eight> pull_a{a.w * n.x, a.w * n.y, a.w * n.z};
  const Vec3Lanes<Eight> pull_b{b.w * n.x, b.w * n.y, b.w * n.z};
  const Vec3Lanes<Eight> pulls{pull_a.x + pull_b.x, pull_a.y + pull_b.y, pull_a.z + pull_b.z};
  const Eight stiffness = Eight::load(group.stiffness.data());
  const Eight multiplier = order.is_first ? Eight::of(0.0) : Eight::load(group.multiplier.data());
  Eight off = multiplier + stiffness * elongation;
  Eight resists = stiffness;
  if constexpr (kDamped) {
    const Eight damping = Eight::load(group.damping.data());
    const Vec3Lanes<Eight> moved_before =
        subtract_lanes(Eight::load_rows(rows.before, at_b), Eight::load_rows(rows.before, at_a));
    off = off + damping * dot_lanes(n, subtract_lanes(moved, moved_before));
    resists = stiffness + damping;
  }
  // -dl.
  const Eight back = has_direction * (off / (one + resists * dot_lanes(n, pulls)));
  if (!order.is_last) (multiplier - back).store(group.multiplier.data());
  Eight::store_whole_rows(rows.now, at_a, pulled_lanes(a, back, pull_a));
  Eight::store_whole_rows(rows.now, at_b, pulled_lanes(b, Eight::of(0.0) - back, pull_b));
}

/// As sweep_springs, for springs of one kind.
template <typename Eight, bool kLinear, bool kDamped>
PALPATE_LANES_TARGET void sweep_kind(const SpringRun& run, const SweptRows& rows, const SweepOrder& order) {
  const std::size_t count = run.groups.size();
  if (order.is_backward) {
    for (std::size_t k = count; k > 0; --k)
      sweep_group<Eight, kLinear, kDamped>(run.groups[k - 1], rows, order);
  } else {
    for (std::size_t k = 0; k < count; ++k) sweep_group<Eight, kLinear, kDamped>(run.groups[k], rows, order);
  }
}

/// As sweep_springs.
template <typename Eight>
PALPATE_LANES_TARGET void sweep_springs_in_lanes(const SpringRun& run, const SweptRows& rows,
                                                 const SweepOrder& order) {
  if (run.is_linear) {
    if (run.is_damped) return sweep_kind<Eight, true, true>(run, rows, order);
    return sweep_kind<Eight, true, false>(run, rows, order);
  }
  if (run.is_damped) return sweep_kind<Eight, false, true>(run, rows, order);
  sweep_kind<Eight, false, false>(run, rows, order);
}

}  // namespace palpate::dynamics

// Gradients and forces of eight domains, whatever eight numbers are made of: the body of both forms of
// add_domain_forces. core/dynamics/tet_engine/law_lanes.h says how a source chooses its instruction set.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/dynamics/spring_engine/plain_kernel.h"
#include "core/dynamics/tet_engine/domain_kernel.h"
#include "core/dynamics/tet_engine/law_lanes.h"

namespace palpate::dynamics {

/// sum over k > 0 of (u_k - u_0) (x) g_k. `kVertices` is their number, or 0 where `count` is not known.
template <typename Eight, std::size_t kVertices, typename Place>
PALPATE_LANES Mat3Lanes<Eight> gradient_lanes(const typename Eight::Number* gradients, const Place* at,
                                              std::size_t count, const typename Eight::Number* rows) {
  const std::size_t n = kVertices != 0 ? kVertices : count;
  const Vec3Lanes<Eight> hub = Eight::load_rows(rows, at);
  const Eight zero = Eight::of(0);
  Mat3Lanes<Eight> h{zero, zero, zero, zero, zero, zero, zero, zero, zero};
  for (std::size_t k = 1; k < n; ++k) {
    const Vec3Lanes<Eight> u = Eight::load_rows(rows, at + kGroupDomains * k);
    const Eight dx = u.x - hub.x;
    const Eight dy = u.y - hub.y;
    const Eight dz = u.z - hub.z;
    const typename Eight::Number* g = gradients + 3 * kGroupDomains * (k - 1);
    const Eight gx = Eight::load(g);
    const Eight gy = Eight::load(g + kGroupDomains);
    const Eight gz = Eight::load(g + 2 * kGroupDomains);
    const Mat3Lanes<Eight> part{dx * gx, dx * gy, dx * gz, dy * gx, dy * gy,
                                dy * gz, dz * gx, dz * gy, dz * gz};
    if (k == 1) {
      h = part;
    } else {
      for (std::size_t i = 0; i < 9; ++i) h[i] = h[i] + part[i];
    }
  }
  return h;
}

/// Fetches the cache lines of `count` numbers at `where`, which may lie past the end of an array.
template <typename Number>
PALPATE_LANES void fetch_numbers(const Number* where, std::size_t count) {
  const auto* bytes = reinterpret_cast<const char*>(where);
  for (std::size_t k = 0; k < count * sizeof(Number); k += 64) fetch_ahead(bytes + k);
}

/// Adds the forces of -V P = `p` of a group.
template <typename Eight, std::size_t kVertices>
PALPATE_LANES void add_stress(const Mat3Lanes<Eight>& p, const typename Eight::Number* gradients,
                              const std::uint16_t* at, std::size_t count, typename Eight::Number* force) {
  const std::size_t n = kVertices != 0 ? kVertices : count;
  const Eight zero = Eight::of(0);
  Vec3Lanes<Eight> sum{zero, zero, zero};
  for (std::size_t k = 1; k < n; ++k) {
    const typename Eight::Number* g = gradients + 3 * kGroupDomains * (k - 1);
    const Eight gx = Eight::load(g);
    const Eight gy = Eight::load(g + kGroupDomains);
    const Eight gz = Eight::load(g + 2 * kGroupDomains);
    const Vec3Lanes<Eight> f{dot_lanes(p[0], gx, p[1], gy, p[2], gz), dot_lanes(p[3], gx, p[4], gy, p[5], gz),
                             dot_lanes(p[6], gx, p[7], gy, p[8], gz)};
    Eight::add_rows(force, at + kGroupDomains * k, f);
    sum = {sum.x - f.x, sum.y - f.y, sum.z - f.z};
  }
  Eight::add_rows(force, at, sum);
}

/// Groups between whose passes roots and quotients are on their way.
inline constexpr std::size_t kBatchGroups = 4;

/// As add_domain_forces, for one law, with damping or without. `kVertices` is the number of vertices of a
/// domain, or 0 for any. Batches go through gradients, roots and forces, so that no pass waits for its own
/// divisions.
template <typename Eight, StrainLaw kLaw, bool kDamped, std::size_t kVertices>
PALPATE_LANES_TARGET void add_run(const DomainLaw& law, const DomainRun<typename Eight::Number>& run,
                                  const BlockMotion<typename Eight::Number>& motion,
                                  typename Eight::Number* force) {
  using Real = typename Eight::Number;
  const std::size_t n = kVertices != 0 ? kVertices : run.vertices;
  const std::size_t values_a_group = group_values(n);
  const std::size_t places_a_group = kGroupDomains * n;
  const Eight lambda = Eight::of(static_cast<Real>(-law.moduli.lambda_pa));
  const Eight mu = Eight::of(static_cast<Real>(-law.moduli.mu_pa));
  const Eight damping = Eight::of(static_cast<Real>(law.damping_s));
  std::array<Pending<Eight>, kBatchGroups> pending;
  for (std::size_t first = 0; first < run.groups; first += kBatchGroups) {
    const std::size_t last = first + kBatchGroups < run.groups ? first + kBatchGroups : run.groups;
    for (std::size_t group = first; group < last; ++group) {
      const Real* values = run.values + group * values_a_group;
      const std::uint16_t* at = run.at + group * places_a_group;
      fetch_numbers(values + kBatchGroups * values_a_group, values_a_group);
      fetch_numbers(at + kBatchGroups * places_a_group, places_a_group);
      Pending<Eight>& each = pending[group - first];
      each.h = gradient_lanes<Eight, kVertices>(values + kGroupDomains, at, n, motion.u);
      if constexpr (kDamped)
        each.rate = gradient_lanes<Eight, kVertices>(values + kGroupDomains, at, n, motion.v);
      if constexpr (kLaw != StrainLaw::kLinear) find_change(each.h, each.at);
      if constexpr (kLaw == StrainLaw::kCorotated) {
        find_strain(each.h, each.at);
        start_trace(each.at, each.root);
      }
    }
    for (std::size_t group = first; group < last; ++group) {
      Pending<Eight>& each = pending[group - first];
      if constexpr (kLaw == StrainLaw::kCorotated) find_trace(each.at.change, each.root);
      if constexpr (kLaw == StrainLaw::kNeoHookean) find_logarithm(each);
    }
    for (std::size_t group = first; group < last; ++group) {
      const Real* values = run.values + group * values_a_group;
      const Pending<Eight>& each = pending[group - first];
      const Eight volume = Eight::load(values);
      const ModuliLanes<Eight> moduli{lambda * volume, mu * volume, damping};
      Mat3Lanes<Eight> p;
      if constexpr (kLaw == StrainLaw::kLinear) p = linear_stress(moduli, each.h);
      if constexpr (kLaw == StrainLaw::kCorotated)
        p = corotated_stress<Eight, kDamped>(law, moduli, volume, each);
      if constexpr (kLaw == StrainLaw::kNeoHookean)
        p = neo_hookean_stress<Eight, kDamped>(law, moduli, volume, each);
      if constexpr (kLaw == StrainLaw::kStableNeoHookean) p = stable_stress<Eight, kDamped>(moduli, each);
      add_stress<Eight, kVertices>(p, values + kGroupDomains, run.at + group * places_a_group, n, force);
    }
  }
}

/// One law's domains: those of four vertices have a loop of their own.
template <typename Eight, StrainLaw kLaw, bool kDamped>
PALPATE_LANES_TARGET void add_law(const DomainLaw& law, const DomainRun<typename Eight::Number>& run,
                                  const BlockMotion<typename Eight::Number>& motion,
                                  typename Eight::Number* force) {
  if (run.vertices == 4) return add_run<Eight, kLaw, kDamped, 4>(law, run, motion, force);
  add_run<Eight, kLaw, kDamped, 0>(law, run, motion, force);
}

/// add_domain_forces with eight numbers of this kind.
template <typename Eight>
PALPATE_LANES_TARGET void add_forces_in_lanes(const DomainLaw& law,
                                              const DomainRun<typename Eight::Number>& run,
                                              const BlockMotion<typename Eight::Number>& motion,
                                              typename Eight::Number* force) {
  const bool is_damped = law.damping_s != 0.0;
  if (law.law == StrainLaw::kLinear)
    return add_law<Eight, StrainLaw::kLinear, false>(law, run, motion, force);
  if (law.law == StrainLaw::kCorotated) {
    if (is_damped) return add_law<Eight, StrainLaw::kCorotated, true>(law, run, motion, force);
    return add_law<Eight, StrainLaw::kCorotated, false>(law, run, motion, force);
  }
  if (law.law == StrainLaw::kStableNeoHookean) {
    if (is_damped) return add_law<Eight, StrainLaw::kStableNeoHookean, true>(law, run, motion, force);
    return add_law<Eight, StrainLaw::kStableNeoHookean, false>(law, run, motion, force);
  }
  if (is_damped) return add_law<Eight, StrainLaw::kNeoHookean, true>(law, run, motion, force);
  add_law<Eight, StrainLaw::kNeoHookean, false>(law, run, motion, force);
}

}  // namespace palpate::dynamics

// Gradients and forces of eight domains, whatever eight numbers are made of: the body of both forms of
// add_domain_forces. core/dynamics/tet_engine/law_lanes.h says how a source chooses its instruction set.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/dynamics/tet_engine/domain_kernel.h"
#include "core/dynamics/tet_engine/law_lanes.h"

namespace palpate::dynamics {

/// sum over k > 0 of (u_k - u_0) (x) g_k. `kVertices` is their number, or 0 where `count` is not known.
template <typename Eight, std::size_t kVertices>
PALPATE_LANES Mat3Lanes<Eight> gradient_lanes(const typename Eight::Number* gradients,
                                              const std::uint16_t* at, std::size_t count,
                                              const typename Eight::Number* rows) {
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

/// As add_domain_forces, for one law, with damping or without. `kVertices` is the number of vertices of a
/// domain, or 0 for any.
template <typename Eight, StrainLaw kLaw, bool kDamped, std::size_t kVertices>
PALPATE_LANES_TARGET void add_run(const DomainLaw& law, const DomainRun<typename Eight::Number>& run,
                                  const BlockMotion<typename Eight::Number>& motion,
                                  typename Eight::Number* force) {
  using Real = typename Eight::Number;
  const std::size_t n = kVertices != 0 ? kVertices : run.vertices;
  const Real* values = run.values;
  const std::uint16_t* at = run.at;
  const Eight lambda = Eight::of(static_cast<Real>(-law.moduli.lambda_pa));
  const Eight mu = Eight::of(static_cast<Real>(-law.moduli.mu_pa));
  const Eight damping = Eight::of(static_cast<Real>(law.damping_s));
  for (std::size_t group = 0; group < run.groups; ++group) {
    const Eight volume = Eight::load(values);
    const Real* gradients = values + kGroupDomains;
    const Mat3Lanes<Eight> h = gradient_lanes<Eight, kVertices>(gradients, at, n, motion.u);
    const ModuliLanes<Eight> moduli{lambda * volume, mu * volume, damping};
    Mat3Lanes<Eight> rate;
    if constexpr (kDamped) rate = gradient_lanes<Eight, kVertices>(gradients, at, n, motion.v);
    Mat3Lanes<Eight> p;
    if constexpr (kLaw == StrainLaw::kLinear) p = linear_stress(moduli, h);
    if constexpr (kLaw == StrainLaw::kCorotated)
      p = corotated_stress<Eight, kDamped>(law, moduli, volume, h, kDamped ? rate : h);
    if constexpr (kLaw == StrainLaw::kNeoHookean)
      p = neo_hookean_stress<Eight, kDamped>(law, moduli, volume, h, kDamped ? rate : h);
    const Eight zero = Eight::of(0);
    Vec3Lanes<Eight> sum{zero, zero, zero};
    for (std::size_t k = 1; k < n; ++k) {
      const Real* g = gradients + 3 * kGroupDomains * (k - 1);
      const Eight gx = Eight::load(g);
      const Eight gy = Eight::load(g + kGroupDomains);
      const Eight gz = Eight::load(g + 2 * kGroupDomains);
      const Vec3Lanes<Eight> f{dot_lanes(p[0], gx, p[1], gy, p[2], gz),
                               dot_lanes(p[3], gx, p[4], gy, p[5], gz),
                               dot_lanes(p[6], gx, p[7], gy, p[8], gz)};
      Eight::add_rows(force, at + kGroupDomains * k, f);
      sum = {sum.x - f.x, sum.y - f.y, sum.z - f.z};
    }
    Eight::add_rows(force, at, sum);
    values += group_values(n);
    at += kGroupDomains * n;
  }
}

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
  if (is_damped) return add_law<Eight, StrainLaw::kNeoHookean, true>(law, run, motion, force);
  add_law<Eight, StrainLaw::kNeoHookean, false>(law, run, motion, force);
}

}  // namespace palpate::dynamics

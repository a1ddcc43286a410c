// Stresses of eight domains by law: part of both forms of add_domain_forces. Compiled for the instruction set
// of who includes it (matrix_lanes.h).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/dynamics/tet_engine/domain_kernel.h"
#include "core/dynamics/tet_engine/matrix_lanes.h"

namespace palpate::dynamics {

/// How often and how far Newton's steps go, and where the series of the logarithm ends.
template <typename Real>
struct LaneLimits;
/// Of single precision: a last step of 3e-4 leaves an error of 3e-8.
template <>
struct LaneLimits<float> {
  static constexpr int kNewtonSteps = 3;
  static constexpr float kLastStepSq = 1e-7F;
  static constexpr int kLogTerms = 7;
};
/// Of double precision.
template <>
struct LaneLimits<double> {
  static constexpr int kNewtonSteps = 4;
  static constexpr double kLastStepSq = 1e-16;
  static constexpr int kLogTerms = 16;
};

/// What the laws share: moduli times -V, and the damping's share of them.
template <typename Eight>
struct ModuliLanes {
  Eight lambda;
  Eight mu;
  Eight damping;
};

/// lambda tr h I + mu (h + h^T).
template <typename Eight>
PALPATE_LANES Mat3Lanes<Eight> linear_stress(const ModuliLanes<Eight>& moduli, const Mat3Lanes<Eight>& h) {
  const Eight spread = moduli.lambda * ((h[0] + h[4]) + h[8]);
  const Eight two_mu = moduli.mu + moduli.mu;
  const Eight xy = moduli.mu * (h[1] + h[3]);
  const Eight xz = moduli.mu * (h[2] + h[6]);
  const Eight yz = moduli.mu * (h[5] + h[7]);
  return {two_mu * h[0] + spread, xy, xz, xy, two_mu * h[4] + spread, yz, xz, yz, two_mu * h[8] + spread};
}

/// E = F^T F - I of F = I + h, and the change of volume j = det F - 1.
template <typename Eight>
struct Stretched {
  Mat3Lanes<Eight> cofactors;  ///< of h
  SymmetricLanes<Eight> e;
  Eight trace;   ///< of h
  Eight second;  ///< j - tr h
  Eight change;  ///< j
};

/// The change of volume and what it is made of, from h.
template <typename Eight>
PALPATE_LANES void find_change(const Mat3Lanes<Eight>& h, Stretched<Eight>& out) {
  out.cofactors = cofactor_lanes(h);
  const Mat3Lanes<Eight>& c = out.cofactors;
  out.trace = (h[0] + h[4]) + h[8];
  out.second = ((c[0] + c[4]) + c[8]) + dot_lanes(h[0], c[0], h[1], c[1], h[2], c[2]);
  out.change = out.trace + out.second;
}

/// E from h.
template <typename Eight>
PALPATE_LANES void find_strain(const Mat3Lanes<Eight>& h, Stretched<Eight>& out) {
  out.e.xx = (h[0] + h[0]) + dot_lanes(h[0], h[0], h[3], h[3], h[6], h[6]);
  out.e.yy = (h[4] + h[4]) + dot_lanes(h[1], h[1], h[4], h[4], h[7], h[7]);
  out.e.zz = (h[8] + h[8]) + dot_lanes(h[2], h[2], h[5], h[5], h[8], h[8]);
  out.e.xy = (h[1] + h[3]) + dot_lanes(h[0], h[1], h[3], h[4], h[6], h[7]);
  out.e.xz = (h[2] + h[6]) + dot_lanes(h[0], h[2], h[3], h[5], h[6], h[8]);
  out.e.yz = (h[5] + h[7]) + dot_lanes(h[1], h[2], h[4], h[5], h[7], h[8]);
}

/// The largest root x = 3 + y of (x^2 - I1)^2 - 4 I2 - 8 J x, which is tr S; I1 and I2 are the invariants of
/// F^T F. With a = tr E, b the second invariant of E and q = 6 y + y^2 - a it is
///
///   y (64 + 12 y - 8 j) + q^2 = 20 a + 4 b + 24 j
///
/// and a quarter of the slope there is D = 2 (s1 + s2)(s2 + s3)(s3 + s1).
template <typename Eight>
struct TraceRoot {
  Eight a;
  Eight target;  ///< the right-hand side
  Eight y;
  Eight last_step;
  Eight margin;  ///< below zero where D is small or the root another one
  Eight two_over_d;
  Eight m;
};

/// Begins with y = tr(sqrt(I + E) - I) = tr(E/2 - E^2/8 + E^3/16 - ...).
template <typename Eight>
PALPATE_LANES void start_trace(const Stretched<Eight>& at, TraceRoot<Eight>& root) {
  using Real = typename Eight::Number;
  const SymmetricLanes<Eight>& e = at.e;
  const Eight yz_sq = e.yz * e.yz;
  const Eight xz_sq = e.xz * e.xz;
  const Eight xy_sq = e.xy * e.xy;
  const Eight a = (e.xx + e.yy) + e.zz;
  const Eight b = ((e.xx * e.yy - xy_sq) + (e.yy * e.zz - yz_sq)) + (e.zz * e.xx - xz_sq);
  const Eight mixed = e.xy * e.xz;
  const Eight det = (e.xx * (e.yy * e.zz - yz_sq) + (mixed + mixed) * e.yz) - (e.yy * xz_sq + e.zz * xy_sq);
  const Eight square = a * a;
  const Eight tr_square = square - (b + b);
  const Eight tr_cube = a * (square - Eight::of(3) * b) + Eight::of(3) * det;
  root.a = a;
  root.target = (Eight::of(20) * a + Eight::of(4) * b) + Eight::of(24) * at.change;
  root.y =
      (Eight::of(Real(0.5)) * a - Eight::of(Real(0.125)) * tr_square) + Eight::of(Real(0.0625)) * tr_cube;
}

/// Newton's steps. The margin is D - x^3 / 50, four times; at rest D is 16 and x^3 27.
template <typename Eight>
PALPATE_LANES void find_trace(const Eight& change, TraceRoot<Eight>& root) {
  using Real = typename Eight::Number;
  const Eight eight_j = Eight::of(8) * change;
  const Eight base = Eight::of(64) - eight_j;
  const Eight twelve = Eight::of(12);
  const Eight six = Eight::of(6);
  Eight y = root.y;
  Eight last_step = Eight::of(0);
  for (int k = 0; k < LaneLimits<Real>::kNewtonSteps; ++k) {
    const Eight q = y * (six + y) - root.a;
    const Eight value = (y * (base + twelve * y) + q * q) - root.target;
    const Eight slope = (base + (twelve + twelve) * y) + q * (twelve + Eight::of(4) * y);
    last_step = value / slope;
    y = y - last_step;
  }
  const Eight q = y * (six + y) - root.a;
  const Eight slope = (base + (twelve + twelve) * y) + q * (twelve + Eight::of(4) * y);
  const Eight x = Eight::of(3) + y;
  root.y = y;
  root.last_step = last_step;
  root.margin = slope - Eight::of(Real(0.08)) * (x * (x * x));
  root.two_over_d = Eight::of(8) / slope;
  root.m = ((six * y + (q + q)) + y * q) - (Eight::of(Real(0.25)) * eight_j + (root.a + root.a));
}

/// D (F - R) / 2 = (m/2 + 3) H + (3 + y)(H^T - cof H) + E + H E + (m/2 - (3 + y) tr H - y) I.
template <typename Eight>
PALPATE_LANES Mat3Lanes<Eight> find_apart(const Mat3Lanes<Eight>& h, const Stretched<Eight>& at,
                                          const TraceRoot<Eight>& root) {
  using Real = typename Eight::Number;
  const Eight x = Eight::of(3) + root.y;
  const Eight half_m = Eight::of(Real(0.5)) * root.m;
  const Eight own = half_m + Eight::of(3);
  const Eight even = (half_m - root.y) - x * at.trace;
  const SymmetricLanes<Eight>& e = at.e;
  const Mat3Lanes<Eight> full{e.xx, e.xy, e.xz, e.xy, e.yy, e.yz, e.xz, e.yz, e.zz};
  const Mat3Lanes<Eight> bent = multiply_lanes(h, full);
  const Mat3Lanes<Eight> turned = transpose_lanes(h);
  Mat3Lanes<Eight> d;
  for (std::size_t i = 0; i < 9; ++i)
    d[i] = (own * h[i] + x * (turned[i] - at.cofactors[i])) + (full[i] + bent[i]);
  for (std::size_t i = 0; i < 9; i += 4) d[i] = d[i] + even;
  return d;
}

/// Whether some domain's root cannot be relied on; with damping a mirrored one neither.
template <typename Eight, bool kDamped>
PALPATE_LANES bool is_any_off(const TraceRoot<Eight>& root, const Eight& change) {
  using Real = typename Eight::Number;
  const Eight zero = Eight::of(0);
  return any_less(Eight::of(LaneLimits<Real>::kLastStepSq), root.last_step * root.last_step) ||
         any_less(root.margin, zero) || any_less(Eight::of(3) + root.y, zero) ||
         (kDamped && any_less(Eight::of(1) + change, zero));
}

/// The same, domain by domain.
template <typename Eight, bool kDamped>
PALPATE_LANES std::array<bool, kGroupDomains> find_off(const TraceRoot<Eight>& root, const Eight& change) {
  using Real = typename Eight::Number;
  std::array<std::array<Real, kGroupDomains>, 4> each;
  root.last_step.store(each[0].data());
  root.margin.store(each[1].data());
  (Eight::of(3) + root.y).store(each[2].data());
  (Eight::of(1) + change).store(each[3].data());
  std::array<bool, kGroupDomains> out;
  for (std::size_t i = 0; i < kGroupDomains; ++i)
    out[i] = each[0][i] * each[0][i] > LaneLimits<Real>::kLastStepSq || each[1][i] < 0 || each[2][i] < 0 ||
             (kDamped && each[3][i] < 0);
  return out;
}

/// Each of eight domains' nine numbers, by number.
template <typename Eight>
PALPATE_LANES void store_lanes(const Mat3Lanes<Eight>& from,
                               std::array<std::array<typename Eight::Number, kGroupDomains>, 9>& to) {
  for (std::size_t i = 0; i < 9; ++i) from[i].store(to[i].data());
}

/// Puts right what is off; `is_off` says for each domain whether it is.
template <typename Eight, bool kDamped>
PALPATE_LANES void mend(const DomainLaw& law, const Eight& volume, const Mat3Lanes<Eight>& h,
                        const Mat3Lanes<Eight>& rate, const std::array<bool, kGroupDomains>& is_off,
                        Mat3Lanes<Eight>& p) {
  EightDomains<typename Eight::Number> domains;
  store_lanes(h, domains.h);
  if (kDamped) store_lanes(rate, domains.rate);
  store_lanes(p, domains.stress);
  volume.store(domains.volume.data());
  domains.is_off = is_off;
  mend_domains(law, domains);
  for (std::size_t i = 0; i < 9; ++i) p[i] = Eight::load(domains.stress[i].data());
}

/// damping_stress of kCorotated for F = R S with S positive; `d` is F - R. Adds to `p`.
template <typename Eight>
PALPATE_LANES void add_corotated_damping(const ModuliLanes<Eight>& moduli, const Mat3Lanes<Eight>& h,
                                         const Mat3Lanes<Eight>& d, const TraceRoot<Eight>& root,
                                         const Mat3Lanes<Eight>& rate, Mat3Lanes<Eight>& p) {
  using Real = typename Eight::Number;
  const Eight one = Eight::of(1);
  Mat3Lanes<Eight> turn;
  for (std::size_t i = 0; i < 9; ++i) turn[i] = h[i] - d[i];
  for (std::size_t i = 0; i < 9; i += 4) turn[i] = one + turn[i];
  // S - I = sym(R^T (F - R)), G = (2 + y) I - (S - I), its inverse its cofactors over D / 2.
  const Mat3Lanes<Eight> strain = multiply_lanes(transpose_lanes(turn), d);
  const Eight half = Eight::of(Real(0.5));
  const SymmetricLanes<Eight> s{one + strain[0],
                                one + strain[4],
                                one + strain[8],
                                half * (strain[5] + strain[7]),
                                half * (strain[2] + strain[6]),
                                half * (strain[1] + strain[3])};
  const Eight x = Eight::of(3) + root.y;
  const Eight gx = x - s.xx;
  const Eight gy = x - s.yy;
  const Eight gz = x - s.zz;
  const Eight scale = root.two_over_d;
  const SymmetricLanes<Eight> inverse{scale * (gy * gz - s.yz * s.yz),   scale * (gz * gx - s.xz * s.xz),
                                      scale * (gx * gy - s.xy * s.xy),   scale * (gx * s.yz + s.xy * s.xz),
                                      scale * (gy * s.xz + s.xy * s.yz), scale * (gz * s.xy + s.xz * s.yz)};
  const Mat3Lanes<Eight> b = multiply_lanes(transpose_lanes(turn), rate);
  const Vec3Lanes<Eight> w = multiply_lanes(inverse, Vec3Lanes<Eight>{b[7] - b[5], b[2] - b[6], b[3] - b[1]});
  // dU/dt = sym(B - [w]x S).
  const SymmetricLanes<Eight> stretch{
      b[0] - (w.y * s.xz - w.z * s.xy),
      b[4] - (w.z * s.xy - w.x * s.yz),
      b[8] - (w.x * s.yz - w.y * s.xz),
      half * ((b[5] + b[7]) - ((w.z * s.xz - w.x * s.zz) + (w.x * s.yy - w.y * s.xy))),
      half * ((b[2] + b[6]) - ((w.y * s.zz - w.z * s.yz) + (w.x * s.xy - w.y * s.xx))),
      half * ((b[1] + b[3]) - ((w.y * s.yz - w.z * s.yy) + (w.z * s.xx - w.x * s.xz)))};
  const Eight viscous_mu = moduli.damping * (moduli.mu + moduli.mu);
  const Eight spread = (moduli.damping * moduli.lambda) * ((stretch.xx + stretch.yy) + stretch.zz);
  const SymmetricLanes<Eight> t{viscous_mu * stretch.xx + spread, viscous_mu * stretch.yy + spread,
                                viscous_mu * stretch.zz + spread, viscous_mu * stretch.yz,
                                viscous_mu * stretch.xz,          viscous_mu * stretch.xy};
  // Axial of T S.
  const Vec3Lanes<Eight> axial{
      dot_lanes(t.xz, s.xy, t.yz, s.yy, t.zz, s.yz) - dot_lanes(t.xy, s.xz, t.yy, s.yz, t.yz, s.zz),
      dot_lanes(t.xx, s.xz, t.xy, s.yz, t.xz, s.zz) - dot_lanes(t.xz, s.xx, t.yz, s.xy, t.zz, s.xz),
      dot_lanes(t.xy, s.xx, t.yy, s.xy, t.yz, s.xz) - dot_lanes(t.xx, s.xy, t.xy, s.yy, t.xz, s.yz)};
  const Vec3Lanes<Eight> y = multiply_lanes(inverse, axial);
  const Mat3Lanes<Eight> inner{t.xx,       t.xy + y.z, t.xz - y.y, t.xy - y.z, t.yy,
                               t.yz + y.x, t.xz + y.y, t.yz - y.x, t.zz};
  const Mat3Lanes<Eight> viscous = multiply_lanes(turn, inner);
  for (std::size_t i = 0; i < 9; ++i) p[i] = p[i] + viscous[i];
}

/// What is known of eight domains between the passes of a batch.
template <typename Eight>
struct Pending {
  Mat3Lanes<Eight> h;
  Mat3Lanes<Eight> rate;
  Stretched<Eight> at;
  TraceRoot<Eight> root;  ///< kCorotated
  Eight inverse;          ///< kNeoHookean: 1 / J
  Eight log_j;
  Eight z_sq;
};

/// P = 2 mu (F - R) + lambda y R.
template <typename Eight, bool kDamped>
PALPATE_LANES Mat3Lanes<Eight> corotated_stress(const DomainLaw& law, const ModuliLanes<Eight>& moduli,
                                                const Eight& volume, const Pending<Eight>& from) {
  const Mat3Lanes<Eight>& h = from.h;
  const Stretched<Eight>& at = from.at;
  const TraceRoot<Eight>& root = from.root;
  Mat3Lanes<Eight> d = find_apart(h, at, root);
  const Eight pull = moduli.lambda * root.y;
  const Eight shear = ((moduli.mu + moduli.mu) - pull) * root.two_over_d;
  Mat3Lanes<Eight> p;
  for (std::size_t i = 0; i < 9; ++i) p[i] = shear * d[i] + pull * h[i];
  for (std::size_t i = 0; i < 9; i += 4) p[i] = p[i] + pull;
  if constexpr (kDamped) {
    for (std::size_t i = 0; i < 9; ++i) d[i] = root.two_over_d * d[i];
    add_corotated_damping(moduli, h, d, root, from.rate, p);
  }
  if (is_any_off<Eight, kDamped>(root, at.change))
    mend<Eight, kDamped>(law, volume, h, from.rate, find_off<Eight, kDamped>(root, at.change), p);
  return p;
}

/// 1 / J and ln J = 2 artanh(z), z = j / (2 + j).
template <typename Eight>
PALPATE_LANES void find_logarithm(Pending<Eight>& of) {
  using Real = typename Eight::Number;
  const Eight change = of.at.change;
  of.inverse = Eight::of(1) / (Eight::of(1) + change);
  const Eight z = change / (Eight::of(2) + change);
  of.z_sq = z * z;
  Eight series = Eight::of(Real(2) / Real(2 * LaneLimits<Real>::kLogTerms - 1));
  for (int k = LaneLimits<Real>::kLogTerms - 2; k >= 0; --k)
    series = series * of.z_sq + Eight::of(Real(2) / Real(2 * k + 1));
  of.log_j = z * series;
}

/// P = mu (F - G) + lambda ln J G, G = F^-T = (I + tr H I - H^T + cof H) / J;
/// F - G = H + ((j - tr H) I + H^T - cof H) / J.
template <typename Eight, bool kDamped>
PALPATE_LANES Mat3Lanes<Eight> neo_hookean_stress(const DomainLaw& law, const ModuliLanes<Eight>& moduli,
                                                  const Eight& volume, const Pending<Eight>& from) {
  using Real = typename Eight::Number;
  const Mat3Lanes<Eight>& h = from.h;
  const Mat3Lanes<Eight> turned = transpose_lanes(h);
  Mat3Lanes<Eight> apart;  // F - G
  for (std::size_t i = 0; i < 9; ++i) apart[i] = turned[i] - from.at.cofactors[i];
  for (std::size_t i = 0; i < 9; i += 4) apart[i] = apart[i] + from.at.second;
  for (std::size_t i = 0; i < 9; ++i) apart[i] = h[i] + from.inverse * apart[i];
  // P = (mu - c) (F - G) + c F, c = lambda ln J.
  const Eight pull = moduli.lambda * from.log_j;
  const Eight shear = moduli.mu - pull;
  Mat3Lanes<Eight> p;
  for (std::size_t i = 0; i < 9; ++i) p[i] = shear * apart[i] + pull * h[i];
  for (std::size_t i = 0; i < 9; i += 4) p[i] = p[i] + pull;
  if constexpr (kDamped) {
    Mat3Lanes<Eight> g;
    for (std::size_t i = 0; i < 9; ++i) g[i] = h[i] - apart[i];
    for (std::size_t i = 0; i < 9; i += 4) g[i] = Eight::of(1) + g[i];
    const Mat3Lanes<Eight> spin = multiply_lanes(from.rate, transpose_lanes(g));
    const ModuliLanes<Eight> viscous{moduli.damping * moduli.lambda, moduli.damping * moduli.mu,
                                     moduli.damping};
    const Mat3Lanes<Eight> more = multiply_lanes(linear_stress(viscous, spin), g);
    for (std::size_t i = 0; i < 9; ++i) p[i] = p[i] + more[i];
  }
  constexpr Real kMost = Real(1) / Real(9);  // J from 1/2 to 2
  if (any_less(Eight::of(kMost), from.z_sq)) {
    std::array<Real, kGroupDomains> each;
    from.z_sq.store(each.data());
    std::array<bool, kGroupDomains> is_off;
    for (std::size_t i = 0; i < kGroupDomains; ++i) is_off[i] = each[i] > kMost;
    mend<Eight, kDamped>(law, volume, h, from.rate, is_off, p);
  }
  return p;
}

/// P = mu (H + H^T - tr H I - cof H) + (lambda + mu) j cof F, cof F = (1 + tr H) I - H^T + cof H.
template <typename Eight, bool kDamped>
PALPATE_LANES Mat3Lanes<Eight> stable_stress(const ModuliLanes<Eight>& moduli, const Pending<Eight>& from) {
  const Mat3Lanes<Eight>& h = from.h;
  const Mat3Lanes<Eight> turned = transpose_lanes(h);
  const Eight pressure = (moduli.lambda + moduli.mu) * from.at.change;
  Mat3Lanes<Eight> p;
  for (std::size_t i = 0; i < 9; ++i) {
    const Eight apart = turned[i] - from.at.cofactors[i];
    p[i] = moduli.mu * (h[i] + apart) - pressure * apart;
  }
  const Eight even = pressure * (Eight::of(1) + from.at.trace) - moduli.mu * from.at.trace;
  for (std::size_t i = 0; i < 9; i += 4) p[i] = p[i] + even;
  if constexpr (kDamped) {
    Mat3Lanes<Eight> f = h;
    for (std::size_t i = 0; i < 9; i += 4) f[i] = Eight::of(1) + f[i];
    const ModuliLanes<Eight> viscous{moduli.damping * moduli.lambda, moduli.damping * moduli.mu,
                                     moduli.damping};
    const Mat3Lanes<Eight> rate = multiply_lanes(transpose_lanes(f), from.rate);
    const Mat3Lanes<Eight> more = multiply_lanes(f, linear_stress(viscous, rate));
    for (std::size_t i = 0; i < 9; ++i) p[i] = p[i] + more[i];
  }
  return p;
}

}  // namespace palpate::dynamics

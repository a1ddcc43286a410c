// The body of both forms of sweep_strains, compiled for the instruction set of who includes it
// (core/dynamics/tet_engine/matrix_lanes.h).
#pragma once

#include <array>
#include <cstddef>

#include "core/dynamics/position_kernel/strain_kernel.h"
#include "core/dynamics/tet_engine/domain_lanes.h"

namespace palpate::dynamics {

/// Six strains of each of eight domains: xx, yy, zz, 2 yz, 2 xz, 2 xy.
template <typename Eight>
using Vec6Lanes = std::array<Eight, 6>;

/// One triangle of a symmetric 6 x 6 matrix, row after row (triangle_at).
template <typename Eight>
using Triangle6Lanes = std::array<Eight, 21>;

/// The numbers of a group, lane by lane.
template <typename Eight, std::size_t kCount>
PALPATE_LANES std::array<Eight, kCount> load_each(const double* from) {
  std::array<Eight, kCount> out;
  for (std::size_t k = 0; k < kCount; ++k) out[k] = Eight::load(from + kGroupDomains * k);
  return out;
}

/// The same, or zeros.
template <typename Eight, std::size_t kCount>
PALPATE_LANES std::array<Eight, kCount> load_unless(bool is_zero, const double* from) {
  if (!is_zero) return load_each<Eight, kCount>(from);
  std::array<Eight, kCount> out;
  for (std::size_t k = 0; k < kCount; ++k) out[k] = Eight::of(0.0);
  return out;
}

/// Writes the numbers of a group.
template <typename Eight, std::size_t kCount>
PALPATE_LANES void store_each(const std::array<Eight, kCount>& from, double* to) {
  for (std::size_t k = 0; k < kCount; ++k) from[k].store(to + kGroupDomains * k);
}

/// The whole of a symmetric matrix.
template <typename Eight>
PALPATE_LANES Mat3Lanes<Eight> load_symmetric(const double* from) {
  const std::array<Eight, 6> s = load_each<Eight, 6>(from);
  return {s[0], s[5], s[4], s[5], s[1], s[3], s[4], s[3], s[2]};
}

/// a : b.
template <typename Eight>
PALPATE_LANES Eight contract_lanes(const Mat3Lanes<Eight>& a, const Mat3Lanes<Eight>& b) {
  Eight sum = a[0] * b[0];
  for (std::size_t k = 1; k < 9; ++k) sum = sum + a[k] * b[k];
  return sum;
}

/// I + h.
template <typename Eight>
PALPATE_LANES Mat3Lanes<Eight> add_identity(Mat3Lanes<Eight> h) {
  for (std::size_t i = 0; i < 9; i += 4) h[i] = Eight::of(1.0) + h[i];
  return h;
}

/// The strains of sym(a).
template <typename Eight>
PALPATE_LANES Vec6Lanes<Eight> strain_lanes(const Mat3Lanes<Eight>& a) {
  return {a[0], a[4], a[8], a[5] + a[7], a[2] + a[6], a[1] + a[3]};
}

/// The matrix T with T g = sum over the strains of l times their gradient at a vertex of gradient g.
template <typename Eight>
PALPATE_LANES Mat3Lanes<Eight> stress_lanes(const Vec6Lanes<Eight>& l) {
  return {l[0], l[5], l[4], l[5], l[1], l[3], l[4], l[3], l[2]};
}

/// The square root S of V (lambda, mu) of the six strains.
template <typename Eight>
struct RootLanes {
  Eight even;
  Eight sum;
  Eight shear;
};

/// S of a group.
template <typename Eight>
PALPATE_LANES RootLanes<Eight> root_lanes(const StrainStep& step, const double* values) {
  const Eight root = Eight::load(values + kGroupDomains);
  return {Eight::of(step.root_even) * root, Eight::of(step.root_sum) * root,
          Eight::of(step.root_shear) * root};
}

/// S e.
template <typename Eight>
PALPATE_LANES Vec6Lanes<Eight> multiply_lanes(const RootLanes<Eight>& s, const Vec6Lanes<Eight>& e) {
  const Eight shared = s.sum * ((e[0] + e[1]) + e[2]);
  return {s.even * e[0] + shared, s.even * e[1] + shared, s.even * e[2] + shared,
          s.shear * e[3],         s.shear * e[4],         s.shear * e[5]};
}

/// Moves a group's vertices by W pull g.
template <typename Eight, std::size_t kVertices>
PALPATE_LANES void move_rows(const Mat3Lanes<Eight>& pull, const double* gradients, const std::uint32_t* at,
                             std::size_t count, double* rows) {
  const std::size_t n = kVertices != 0 ? kVertices : count;
  const Eight zero = Eight::of(0.0);
  Vec3Lanes<Eight> sum{zero, zero, zero};
  const auto move = [&](const std::uint32_t* places, const Vec3Lanes<Eight>& by) PALPATE_LANES_TARGET {
    RowLanes<Eight> row = Eight::load_whole_rows(rows, places);
    row.xyz = {row.xyz.x + row.w * by.x, row.xyz.y + row.w * by.y, row.xyz.z + row.w * by.z};
    Eight::store_whole_rows(rows, places, row);
  };
  for (std::size_t k = 1; k < n; ++k) {
    const double* g = gradients + 3 * kGroupDomains * (k - 1);
    const Eight gx = Eight::load(g);
    const Eight gy = Eight::load(g + kGroupDomains);
    const Eight gz = Eight::load(g + 2 * kGroupDomains);
    const Vec3Lanes<Eight> f{dot_lanes(pull[0], gx, pull[1], gy, pull[2], gz),
                             dot_lanes(pull[3], gx, pull[4], gy, pull[5], gz),
                             dot_lanes(pull[6], gx, pull[7], gy, pull[8], gz)};
    move(at + kGroupDomains * k, f);
    sum = {sum.x - f.x, sum.y - f.y, sum.z - f.z};
  }
  move(at, sum);
}

/// F - R, R the rotation nearest to I + h.
template <typename Eight>
PALPATE_LANES Mat3Lanes<Eight> find_apart_from_rotation(const Mat3Lanes<Eight>& h) {
  Stretched<Eight> at;
  find_change(h, at);
  find_strain(h, at);
  TraceRoot<Eight> root;
  start_trace(at, root);
  find_trace(at.change, root);
  Mat3Lanes<Eight> apart = find_apart(h, at, root);
  for (std::size_t i = 0; i < 9; ++i) apart[i] = root.two_over_d * apart[i];
  if (is_any_off<Eight, false>(root, at.change)) {
    EightRotations domains;
    store_lanes(h, domains.h);
    store_lanes(apart, domains.apart);
    mend_rotations(find_off<Eight, false>(root, at.change), domains);
    for (std::size_t i = 0; i < 9; ++i) apart[i] = Eight::load(domains.apart[i].data());
  }
  return apart;
}

/// The numbers of one group.
struct GroupNumbers {
  const double* values;
  const std::uint32_t* at;
  const double* weights;
  double* kept;
  std::size_t vertices;

  const double* gradients() const { return values + 2 * kGroupDomains; }
};

/// A group of kLinear or kCorotated.
template <typename Eight, StrainLaw kLaw, std::size_t kVertices>
PALPATE_LANES void solve_strains(const StrainStep& step, const GroupNumbers& group, const SweptRows& rows,
                                 const SweepOrder& order) {
  const std::size_t n = group.vertices;
  const Mat3Lanes<Eight> h = gradient_lanes<Eight, kVertices>(group.gradients(), group.at, n, rows.now);
  Mat3Lanes<Eight> strain = h;
  Mat3Lanes<Eight> turn;
  if constexpr (kLaw == StrainLaw::kCorotated) {
    const Mat3Lanes<Eight> apart = find_apart_from_rotation(h);
    const Mat3Lanes<Eight> f = add_identity(h);
    for (std::size_t i = 0; i < 9; ++i) turn[i] = f[i] - apart[i];
    strain = multiply_lanes(transpose_lanes(turn), apart);
  }
  const RootLanes<Eight> root = root_lanes<Eight>(step, group.values);
  Vec6Lanes<Eight> wanted = strain_lanes(strain);
  for (Eight& each : wanted) each = Eight::of(step.step_sq) * each;
  if (step.damping != 0.0) {
    Mat3Lanes<Eight> since = gradient_lanes<Eight, kVertices>(group.gradients(), group.at, n, rows.before);
    for (std::size_t i = 0; i < 9; ++i) since[i] = h[i] - since[i];
    if constexpr (kLaw == StrainLaw::kCorotated) since = multiply_lanes(transpose_lanes(turn), since);
    const Vec6Lanes<Eight> rate = strain_lanes(since);
    for (std::size_t k = 0; k < 6; ++k) wanted[k] = wanted[k] + Eight::of(step.damping) * rate[k];
  }
  Vec6Lanes<Eight> multiplier = load_unless<Eight, 6>(order.is_first, group.kept);
  Vec6Lanes<Eight> off = multiply_lanes(root, wanted);
  for (std::size_t k = 0; k < 6; ++k) off[k] = multiplier[k] + off[k];
  Vec6Lanes<Eight> change;
  for (std::size_t i = 0; i < 6; ++i) {
    Eight sum = Eight::of(0.0);
    for (std::size_t j = 0; j < 6; ++j)
      sum = sum - Eight::load(group.weights + kGroupDomains * triangle_at(i, j)) * off[j];
    change[i] = sum;
    multiplier[i] = multiplier[i] + sum;
  }
  if (!order.is_last) store_each(multiplier, group.kept);
  Mat3Lanes<Eight> pull = stress_lanes(multiply_lanes(root, change));
  if constexpr (kLaw == StrainLaw::kCorotated) pull = multiply_lanes(turn, pull);
  move_rows<Eight, kVertices>(pull, group.gradients(), group.at, n, rows.now);
}

/// 1 + c S G S for strains of sym(F^T H), G from C = F^T F and A = sum of W g g^T: the strain of i and j (one
/// or two products of a component of F with one of g) meets that of k and l with C_ik A_jl + ...
template <typename Eight>
PALPATE_LANES Triangle6Lanes<Eight> damping_system(const Mat3Lanes<Eight>& c, const Mat3Lanes<Eight>& a,
                                                   const RootLanes<Eight>& root, const Eight& factor) {
  constexpr std::array<std::array<std::size_t, 2>, 6> kAxes{{{0, 0}, {1, 1}, {2, 2}, {1, 2}, {0, 2}, {0, 1}}};
  std::array<std::array<Eight, 6>, 6> g;
  for (std::size_t p = 0; p < 6; ++p) {
    for (std::size_t q = 0; q <= p; ++q) {
      const auto [i, j] = kAxes[p];
      const auto [k, l] = kAxes[q];
      Eight sum = c[3 * i + k] * a[3 * j + l];
      if (i != j) sum = sum + c[3 * j + k] * a[3 * i + l];
      if (k != l) sum = sum + c[3 * i + l] * a[3 * j + k];
      if (i != j && k != l) sum = sum + c[3 * j + l] * a[3 * i + k];
      g[p][q] = sum;
      g[q][p] = sum;
    }
  }
  for (std::size_t q = 0; q < 6; ++q) {
    const Vec6Lanes<Eight> column =
        multiply_lanes(root, Vec6Lanes<Eight>{g[0][q], g[1][q], g[2][q], g[3][q], g[4][q], g[5][q]});
    for (std::size_t p = 0; p < 6; ++p) g[p][q] = column[p];
  }
  Triangle6Lanes<Eight> out;
  for (std::size_t p = 0; p < 6; ++p) {
    const Vec6Lanes<Eight> row = multiply_lanes(root, g[p]);
    for (std::size_t q = 0; q <= p; ++q) out[triangle_at(p, q)] = factor * row[q];
    out[triangle_at(p, p)] = Eight::of(1.0) + out[triangle_at(p, p)];
  }
  return out;
}

/// A symmetric positive matrix to the factors L D L^T, the diagonal inverted.
template <typename Eight>
PALPATE_LANES void factor_lanes(Triangle6Lanes<Eight>& a) {
  for (std::size_t j = 0; j < 6; ++j) {
    std::array<Eight, 6> scaled;  // L_jk D_k
    Eight d = a[triangle_at(j, j)];
    for (std::size_t k = 0; k < j; ++k) {
      scaled[k] = a[triangle_at(j, k)];
      a[triangle_at(j, k)] = scaled[k] * a[triangle_at(k, k)];
      d = d - a[triangle_at(j, k)] * scaled[k];
    }
    a[triangle_at(j, j)] = Eight::of(1.0) / d;
    for (std::size_t i = j + 1; i < 6; ++i) {
      for (std::size_t k = 0; k < j; ++k)
        a[triangle_at(i, j)] = a[triangle_at(i, j)] - a[triangle_at(i, k)] * a[triangle_at(j, k)];
    }
  }
}

/// x of L D L^T x = b.
template <typename Eight>
PALPATE_LANES void solve_factored(const Triangle6Lanes<Eight>& a, Vec6Lanes<Eight>& b) {
  for (std::size_t i = 1; i < 6; ++i) {
    for (std::size_t k = 0; k < i; ++k) b[i] = b[i] - a[triangle_at(i, k)] * b[k];
  }
  for (std::size_t i = 0; i < 6; ++i) b[i] = a[triangle_at(i, i)] * b[i];
  for (std::size_t i = 5; i > 0; --i) {
    for (std::size_t k = 0; k < i; ++k) b[k] = b[k] - a[triangle_at(i, k)] * b[i];
  }
}

/// The damping of a group of kStableNeoHookean: its six strains about the gradient at the start of the step.
template <typename Eight, std::size_t kVertices>
PALPATE_LANES void damp_stable(const StrainStep& step, const GroupNumbers& group, const SweptRows& rows,
                               const SweepOrder& order) {
  const std::size_t n = group.vertices;
  double* const multipliers = group.kept + 19 * kGroupDomains;
  double* const frames = multipliers + 6 * kGroupDomains;
  double* const factored = frames + 9 * kGroupDomains;
  const RootLanes<Eight> root = root_lanes<Eight>(step, group.values);
  Mat3Lanes<Eight> frame;
  Triangle6Lanes<Eight> factors;
  if (order.is_first) {
    frame = add_identity(gradient_lanes<Eight, kVertices>(group.gradients(), group.at, n, rows.before));
    factors = damping_system(multiply_lanes(transpose_lanes(frame), frame),
                             load_symmetric<Eight>(group.weights), root, Eight::of(step.damping));
    factor_lanes(factors);
    if (!order.is_last) {
      store_each(frame, frames);
      store_each(factors, factored);
    }
  } else {
    frame = load_each<Eight, 9>(frames);
    factors = load_each<Eight, 21>(factored);
  }
  Mat3Lanes<Eight> since =
      add_identity(gradient_lanes<Eight, kVertices>(group.gradients(), group.at, n, rows.now));
  for (std::size_t i = 0; i < 9; ++i) since[i] = since[i] - frame[i];
  Vec6Lanes<Eight> multiplier = load_unless<Eight, 6>(order.is_first, multipliers);
  Vec6Lanes<Eight> off = multiply_lanes(root, strain_lanes(multiply_lanes(transpose_lanes(frame), since)));
  for (std::size_t k = 0; k < 6; ++k) off[k] = multiplier[k] + Eight::of(step.damping) * off[k];
  solve_factored(factors, off);
  for (std::size_t k = 0; k < 6; ++k) {
    multiplier[k] = multiplier[k] - off[k];
    off[k] = Eight::of(0.0) - off[k];
  }
  if (!order.is_last) store_each(multiplier, multipliers);
  const Mat3Lanes<Eight> pull = multiply_lanes(frame, stress_lanes(multiply_lanes(root, off)));
  move_rows<Eight, kVertices>(pull, group.gradients(), group.at, n, rows.now);
}

/// A group of kStableNeoHookean.
template <typename Eight, std::size_t kVertices>
PALPATE_LANES void solve_stable(const StrainStep& step, const GroupNumbers& group, const SweptRows& rows,
                                const SweepOrder& order) {
  if (step.damping != 0.0) damp_stable<Eight, kVertices>(step, group, rows, order);
  const std::size_t n = group.vertices;
  const Mat3Lanes<Eight> h = gradient_lanes<Eight, kVertices>(group.gradients(), group.at, n, rows.now);
  Stretched<Eight> at;
  find_change(h, at);
  const Mat3Lanes<Eight> f = add_identity(h);
  const Mat3Lanes<Eight> slope = cofactor_lanes(f);
  const Eight value = at.change - Eight::of(step.rest);
  const Eight volume = Eight::load(group.values);
  const Eight shear = Eight::of(step.shear) * volume;
  const Eight bulk = Eight::of(step.bulk) * volume;
  const Mat3Lanes<Eight> m = load_symmetric<Eight>(group.weights + 6 * kGroupDomains);
  const Mat3Lanes<Eight> ma = load_symmetric<Eight>(group.weights + 12 * kGroupDomains);
  double* const of_shape = group.kept;
  double* const of_pulled = of_shape + 9 * kGroupDomains;
  double* const of_volume = of_pulled + 9 * kGroupDomains;
  Mat3Lanes<Eight> shape = load_unless<Eight, 9>(order.is_first, of_shape);
  const Mat3Lanes<Eight> pulled = load_unless<Eight, 9>(order.is_first, of_pulled);
  Eight l = order.is_first ? Eight::of(0.0) : Eight::load(of_volume);
  Mat3Lanes<Eight> off;
  for (std::size_t i = 0; i < 9; ++i) off[i] = (l * slope[i] - pulled[i]) - (shape[i] + shear * f[i]);
  const Mat3Lanes<Eight> weighed = multiply_lanes(slope, ma);
  const Eight change = Eight::of(0.0) - (l + bulk * (value + contract_lanes(weighed, off))) /
                                            (Eight::of(1.0) + bulk * contract_lanes(weighed, slope));
  for (std::size_t i = 0; i < 9; ++i) off[i] = off[i] + change * slope[i];
  const Mat3Lanes<Eight> pull = multiply_lanes(off, m);
  l = l + change;
  if (!order.is_last) {
    l.store(of_volume);
    for (std::size_t i = 0; i < 9; ++i) {
      const Eight by_volume = l * slope[i];
      shape[i] = shape[i] + (pull[i] - (by_volume - pulled[i]));
      by_volume.store(of_pulled + kGroupDomains * i);
    }
    store_each(shape, of_shape);
  }
  move_rows<Eight, kVertices>(pull, group.gradients(), group.at, n, rows.now);
}

/// A group of any law.
template <typename Eight, StrainLaw kLaw, std::size_t kVertices>
PALPATE_LANES_TARGET void solve_group(const StrainStep& step, const GroupNumbers& group,
                                      const SweptRows& rows, const SweepOrder& order) {
  if constexpr (kLaw == StrainLaw::kStableNeoHookean) {
    solve_stable<Eight, kVertices>(step, group, rows, order);
  } else {
    solve_strains<Eight, kLaw, kVertices>(step, group, rows, order);
  }
}

/// Groups of one law: those of four vertices have a form of their own.
template <typename Eight, StrainLaw kLaw>
PALPATE_LANES_TARGET void sweep_law(const StrainRun& run, const SweptRows& rows, const SweepOrder& order) {
  const std::size_t count = run.groups.size();
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t g = order.is_backward ? count - 1 - k : k;
    const StrainGroup& from = run.groups[g];
    const GroupNumbers group{run.values + from.values, run.at + from.at,
                             run.weights + kGroupDomains * count_weights(kLaw) * g,
                             run.kept + kGroupDomains * count_kept(kLaw) * g, from.vertices};
    if (from.vertices == 4) {
      solve_group<Eight, kLaw, 4>(run.step, group, rows, order);
    } else {
      solve_group<Eight, kLaw, 0>(run.step, group, rows, order);
    }
  }
}

/// As sweep_strains.
template <typename Eight>
PALPATE_LANES_TARGET void sweep_strains_in_lanes(const StrainRun& run, const SweptRows& rows,
                                                 const SweepOrder& order) {
  if (run.step.law == StrainLaw::kStableNeoHookean)
    return sweep_law<Eight, StrainLaw::kStableNeoHookean>(run, rows, order);
  if (run.step.law == StrainLaw::kLinear) return sweep_law<Eight, StrainLaw::kLinear>(run, rows, order);
  sweep_law<Eight, StrainLaw::kCorotated>(run, rows, order);
}

}  // namespace palpate::dynamics

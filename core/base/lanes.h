// Four numbers at a time, for inner loops: SSE2 where there is one, lane by lane elsewhere.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#ifdef __SSE2__
#include <emmintrin.h>
#endif

namespace palpate {

/// Four lanes, lane by lane. Every operation is IEEE's on each lane, so all forms give the same bits. min is
/// a < b ? a : b, max is a > b ? a : b, so b where a is not a number.
template <typename Real>
struct PortableLanes {
  std::array<Real, 4> v;

  static PortableLanes of(Real all) { return {{all, all, all, all}}; }
  static PortableLanes load(const Real* four) { return {{four[0], four[1], four[2], four[3]}}; }
  void store(Real* four) const { std::copy(v.begin(), v.end(), four); }

  template <typename Operation>
  static PortableLanes each(const PortableLanes& a, const PortableLanes& b, Operation operation) {
    return {{operation(a.v[0], b.v[0]), operation(a.v[1], b.v[1]), operation(a.v[2], b.v[2]),
             operation(a.v[3], b.v[3])}};
  }
  friend PortableLanes operator+(const PortableLanes& a, const PortableLanes& b) {
    return each(a, b, [](Real x, Real y) { return x + y; });
  }
  friend PortableLanes operator-(const PortableLanes& a, const PortableLanes& b) {
    return each(a, b, [](Real x, Real y) { return x - y; });
  }
  friend PortableLanes operator*(const PortableLanes& a, const PortableLanes& b) {
    return each(a, b, [](Real x, Real y) { return x * y; });
  }
  friend PortableLanes operator/(const PortableLanes& a, const PortableLanes& b) {
    return each(a, b, [](Real x, Real y) { return x / y; });
  }
  friend PortableLanes min(const PortableLanes& a, const PortableLanes& b) {
    return each(a, b, [](Real x, Real y) { return x < y ? x : y; });
  }
  friend PortableLanes max(const PortableLanes& a, const PortableLanes& b) {
    return each(a, b, [](Real x, Real y) { return x > y ? x : y; });
  }
  friend PortableLanes sqrt(const PortableLanes& a) {
    return each(a, a, [](Real x, Real) { return std::sqrt(x); });
  }
  /// Whether a < b in any lane.
  friend bool any_less(const PortableLanes& a, const PortableLanes& b) {
    return a.v[0] < b.v[0] || a.v[1] < b.v[1] || a.v[2] < b.v[2] || a.v[3] < b.v[3];
  }
  /// (a0 + a2) + a1 of each of four vectors (x, y, z, 0).
  static PortableLanes sums(const PortableLanes& a, const PortableLanes& b, const PortableLanes& c,
                            const PortableLanes& d) {
    const auto sum = [](const PortableLanes& r) { return (r.v[0] + r.v[2]) + r.v[1]; };
    return {{sum(a), sum(b), sum(c), sum(d)}};
  }
  /// The columns of the matrix whose rows are a, b, c and d.
  static std::array<PortableLanes, 4> turn(const PortableLanes& a, const PortableLanes& b,
                                           const PortableLanes& c, const PortableLanes& d) {
    std::array<PortableLanes, 4> out;
    for (std::size_t i = 0; i < 4; ++i) out[i] = {{a.v[i], b.v[i], c.v[i], d.v[i]}};
    return out;
  }
};

#ifdef __SSE2__

/// Four floats in one register.
struct FloatLanes {
  __m128 v;

  static FloatLanes of(float all) { return {_mm_set1_ps(all)}; }
  static FloatLanes load(const float* four) { return {_mm_loadu_ps(four)}; }
  void store(float* four) const { _mm_storeu_ps(four, v); }
  friend FloatLanes operator+(FloatLanes a, FloatLanes b) { return {_mm_add_ps(a.v, b.v)}; }
  friend FloatLanes operator-(FloatLanes a, FloatLanes b) { return {_mm_sub_ps(a.v, b.v)}; }
  friend FloatLanes operator*(FloatLanes a, FloatLanes b) { return {_mm_mul_ps(a.v, b.v)}; }
  friend FloatLanes operator/(FloatLanes a, FloatLanes b) { return {_mm_div_ps(a.v, b.v)}; }
  friend FloatLanes min(FloatLanes a, FloatLanes b) { return {_mm_min_ps(a.v, b.v)}; }
  friend FloatLanes max(FloatLanes a, FloatLanes b) { return {_mm_max_ps(a.v, b.v)}; }
  friend FloatLanes sqrt(FloatLanes a) { return {_mm_sqrt_ps(a.v)}; }
  friend bool any_less(FloatLanes a, FloatLanes b) { return _mm_movemask_ps(_mm_cmplt_ps(a.v, b.v)) != 0; }
  static FloatLanes sums(FloatLanes a, FloatLanes b, FloatLanes c, FloatLanes d) {
    const __m128 ab_low = _mm_unpacklo_ps(a.v, b.v);   // a0 b0 a1 b1
    const __m128 cd_low = _mm_unpacklo_ps(c.v, d.v);   // c0 d0 c1 d1
    const __m128 ab_high = _mm_unpackhi_ps(a.v, b.v);  // a2 b2 a3 b3
    const __m128 cd_high = _mm_unpackhi_ps(c.v, d.v);
    const __m128 x = _mm_movelh_ps(ab_low, cd_low);
    const __m128 y = _mm_movehl_ps(cd_low, ab_low);
    const __m128 z = _mm_movelh_ps(ab_high, cd_high);
    return {_mm_add_ps(_mm_add_ps(x, z), y)};
  }
  static std::array<FloatLanes, 4> turn(FloatLanes a, FloatLanes b, FloatLanes c, FloatLanes d) {
    const __m128 ab_low = _mm_unpacklo_ps(a.v, b.v);
    const __m128 cd_low = _mm_unpacklo_ps(c.v, d.v);
    const __m128 ab_high = _mm_unpackhi_ps(a.v, b.v);
    const __m128 cd_high = _mm_unpackhi_ps(c.v, d.v);
    return {FloatLanes{_mm_movelh_ps(ab_low, cd_low)}, FloatLanes{_mm_movehl_ps(cd_low, ab_low)},
            FloatLanes{_mm_movelh_ps(ab_high, cd_high)}, FloatLanes{_mm_movehl_ps(cd_high, ab_high)}};
  }
};

/// Four doubles in two registers.
struct DoubleLanes {
  __m128d low;
  __m128d high;

  static DoubleLanes of(double all) { return {_mm_set1_pd(all), _mm_set1_pd(all)}; }
  static DoubleLanes load(const double* four) { return {_mm_loadu_pd(four), _mm_loadu_pd(four + 2)}; }
  void store(double* four) const {
    _mm_storeu_pd(four, low);
    _mm_storeu_pd(four + 2, high);
  }
  friend DoubleLanes operator+(DoubleLanes a, DoubleLanes b) {
    return {_mm_add_pd(a.low, b.low), _mm_add_pd(a.high, b.high)};
  }
  friend DoubleLanes operator-(DoubleLanes a, DoubleLanes b) {
    return {_mm_sub_pd(a.low, b.low), _mm_sub_pd(a.high, b.high)};
  }
  friend DoubleLanes operator*(DoubleLanes a, DoubleLanes b) {
    return {_mm_mul_pd(a.low, b.low), _mm_mul_pd(a.high, b.high)};
  }
  friend DoubleLanes operator/(DoubleLanes a, DoubleLanes b) {
    return {_mm_div_pd(a.low, b.low), _mm_div_pd(a.high, b.high)};
  }
  friend DoubleLanes min(DoubleLanes a, DoubleLanes b) {
    return {_mm_min_pd(a.low, b.low), _mm_min_pd(a.high, b.high)};
  }
  friend DoubleLanes max(DoubleLanes a, DoubleLanes b) {
    return {_mm_max_pd(a.low, b.low), _mm_max_pd(a.high, b.high)};
  }
  friend DoubleLanes sqrt(DoubleLanes a) { return {_mm_sqrt_pd(a.low), _mm_sqrt_pd(a.high)}; }
  friend bool any_less(DoubleLanes a, DoubleLanes b) {
    return _mm_movemask_pd(_mm_or_pd(_mm_cmplt_pd(a.low, b.low), _mm_cmplt_pd(a.high, b.high))) != 0;
  }
  static DoubleLanes sums(DoubleLanes a, DoubleLanes b, DoubleLanes c, DoubleLanes d) {
    const __m128d of_a = _mm_add_pd(a.low, a.high);  // (a0 + a2, a1 + 0)
    const __m128d of_b = _mm_add_pd(b.low, b.high);
    const __m128d of_c = _mm_add_pd(c.low, c.high);
    const __m128d of_d = _mm_add_pd(d.low, d.high);
    return {_mm_add_pd(_mm_unpacklo_pd(of_a, of_b), _mm_unpackhi_pd(of_a, of_b)),
            _mm_add_pd(_mm_unpacklo_pd(of_c, of_d), _mm_unpackhi_pd(of_c, of_d))};
  }
  static std::array<DoubleLanes, 4> turn(DoubleLanes a, DoubleLanes b, DoubleLanes c, DoubleLanes d) {
    return {DoubleLanes{_mm_unpacklo_pd(a.low, b.low), _mm_unpacklo_pd(c.low, d.low)},
            DoubleLanes{_mm_unpackhi_pd(a.low, b.low), _mm_unpackhi_pd(c.low, d.low)},
            DoubleLanes{_mm_unpacklo_pd(a.high, b.high), _mm_unpacklo_pd(c.high, d.high)},
            DoubleLanes{_mm_unpackhi_pd(a.high, b.high), _mm_unpackhi_pd(c.high, d.high)}};
  }
};

/// Which form four lanes of a type of numbers have.
template <typename Real>
struct LanesOf;
/// Of floats.
template <>
struct LanesOf<float> {
  using Type = FloatLanes;
};
/// Of doubles.
template <>
struct LanesOf<double> {
  using Type = DoubleLanes;
};

#else

/// Which form four lanes of a type of numbers have: the portable one.
template <typename Real>
struct LanesOf {
  using Type = PortableLanes<Real>;
};

#endif

/// The fastest form of four lanes there is.
template <typename Real>
using Lanes = typename LanesOf<Real>::Type;

}  // namespace palpate

// Two doubles at a time: SSE2 where there is one, the same arithmetic lane by lane elsewhere.
#pragma once

#include <cmath>

#ifdef __SSE2__
#include <emmintrin.h>
#endif

namespace palpate::simplify {

/// Two lanes. Every operation is IEEE's on each lane, so both forms give the same bits.
struct LanePair {
#ifdef __SSE2__
  __m128d v;

  static LanePair of(double both) {
    return {_mm_set1_pd(both)};
  }
  static LanePair load(const double* two) {
    return {_mm_loadu_pd(two)};
  }
  void store(double* two) const {
    _mm_storeu_pd(two, v);
  }
  friend LanePair operator+(LanePair a, LanePair b) {
    return {_mm_add_pd(a.v, b.v)};
  }
  friend LanePair operator-(LanePair a, LanePair b) {
    return {_mm_sub_pd(a.v, b.v)};
  }
  friend LanePair operator*(LanePair a, LanePair b) {
    return {_mm_mul_pd(a.v, b.v)};
  }
  friend LanePair operator/(LanePair a, LanePair b) {
    return {_mm_div_pd(a.v, b.v)};
  }
  /// a < b ? a : b
  friend LanePair min(LanePair a, LanePair b) {
    return {_mm_min_pd(a.v, b.v)};
  }
  /// a > b ? a : b
  friend LanePair max(LanePair a, LanePair b) {
    return {_mm_max_pd(a.v, b.v)};
  }
  friend LanePair sqrt(LanePair a) {
    return {_mm_sqrt_pd(a.v)};
  }
  /// Whether a < b in any lane.
  friend bool any_less(LanePair a, LanePair b) {
    return _mm_movemask_pd(_mm_cmplt_pd(a.v, b.v)) != 0;
  }
#else
  double v[2];

  static LanePair of(double both) {
    return {{both, both}};
  }
  static LanePair load(const double* two) {
    return {{two[0], two[1]}};
  }
  void store(double* two) const {
    two[0] = v[0];
    two[1] = v[1];
  }
  friend LanePair operator+(LanePair a, LanePair b) {
    return {{a.v[0] + b.v[0], a.v[1] + b.v[1]}};
  }
  friend LanePair operator-(LanePair a, LanePair b) {
    return {{a.v[0] - b.v[0], a.v[1] - b.v[1]}};
  }
  friend LanePair operator*(LanePair a, LanePair b) {
    return {{a.v[0] * b.v[0], a.v[1] * b.v[1]}};
  }
  friend LanePair operator/(LanePair a, LanePair b) {
    return {{a.v[0] / b.v[0], a.v[1] / b.v[1]}};
  }
  friend LanePair min(LanePair a, LanePair b) {
    return {{a.v[0] < b.v[0] ? a.v[0] : b.v[0], a.v[1] < b.v[1] ? a.v[1] : b.v[1]}};
  }
  friend LanePair max(LanePair a, LanePair b) {
    return {{a.v[0] > b.v[0] ? a.v[0] : b.v[0], a.v[1] > b.v[1] ? a.v[1] : b.v[1]}};
  }
  friend LanePair sqrt(LanePair a) {
    return {{std::sqrt(a.v[0]), std::sqrt(a.v[1])}};
  }
  friend bool any_less(LanePair a, LanePair b) {
    return a.v[0] < b.v[0] || a.v[1] < b.v[1];
  }
#endif
};

}  // namespace palpate::simplify

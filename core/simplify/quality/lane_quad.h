// Four floats at a time: SSE2 where there is one, the same arithmetic lane by lane elsewhere.
#pragma once

#include <cmath>

#ifdef __SSE2__
#include <emmintrin.h>
#else
#include <array>
#endif

namespace palpate::simplify {

/// Four lanes. Every operation is IEEE's on each lane, so both forms give the same bits.
struct LaneQuad {
#ifdef __SSE2__
  __m128 v;

  static LaneQuad of(float all) {
    return {_mm_set1_ps(all)};
  }
  static LaneQuad load(const float* four) {
    return {_mm_loadu_ps(four)};
  }
  void store(float* four) const {
    _mm_storeu_ps(four, v);
  }
  friend LaneQuad operator+(LaneQuad a, LaneQuad b) {
    return {_mm_add_ps(a.v, b.v)};
  }
  friend LaneQuad operator-(LaneQuad a, LaneQuad b) {
    return {_mm_sub_ps(a.v, b.v)};
  }
  friend LaneQuad operator*(LaneQuad a, LaneQuad b) {
    return {_mm_mul_ps(a.v, b.v)};
  }
  friend LaneQuad operator/(LaneQuad a, LaneQuad b) {
    return {_mm_div_ps(a.v, b.v)};
  }
  /// a < b ? a : b
  friend LaneQuad min(LaneQuad a, LaneQuad b) {
    return {_mm_min_ps(a.v, b.v)};
  }
  /// a > b ? a : b, so b where a is not a number
  friend LaneQuad max(LaneQuad a, LaneQuad b) {
    return {_mm_max_ps(a.v, b.v)};
  }
  friend LaneQuad sqrt(LaneQuad a) {
    return {_mm_sqrt_ps(a.v)};
  }
  /// Whether a < b in any lane.
  friend bool any_less(LaneQuad a, LaneQuad b) {
    return _mm_movemask_ps(_mm_cmplt_ps(a.v, b.v)) != 0;
  }
#else
  std::array<float, 4> v;

  template <typename Operation>
  static LaneQuad lane_by_lane(const LaneQuad& a, const LaneQuad& b, Operation operation) {
    return {{operation(a.v[0], b.v[0]), operation(a.v[1], b.v[1]), operation(a.v[2], b.v[2]),
             operation(a.v[3], b.v[3])}};
  }

  static LaneQuad of(float all) {
    return {{all, all, all, all}};
  }
  static LaneQuad load(const float* four) {
    return {{four[0], four[1], four[2], four[3]}};
  }
  void store(float* four) const {
    for (int i = 0; i < 4; ++i) four[i] = v[static_cast<unsigned>(i)];
  }
  friend LaneQuad operator+(LaneQuad a, LaneQuad b) {
    return lane_by_lane(a, b, [](float x, float y) { return x + y; });
  }
  friend LaneQuad operator-(LaneQuad a, LaneQuad b) {
    return lane_by_lane(a, b, [](float x, float y) { return x - y; });
  }
  friend LaneQuad operator*(LaneQuad a, LaneQuad b) {
    return lane_by_lane(a, b, [](float x, float y) { return x * y; });
  }
  friend LaneQuad operator/(LaneQuad a, LaneQuad b) {
    return lane_by_lane(a, b, [](float x, float y) { return x / y; });
  }
  friend LaneQuad min(LaneQuad a, LaneQuad b) {
    return lane_by_lane(a, b, [](float x, float y) { return x < y ? x : y; });
  }
  friend LaneQuad max(LaneQuad a, LaneQuad b) {
    return lane_by_lane(a, b, [](float x, float y) { return x > y ? x : y; });
  }
  friend LaneQuad sqrt(LaneQuad a) {
    return {{std::sqrt(a.v[0]), std::sqrt(a.v[1]), std::sqrt(a.v[2]), std::sqrt(a.v[3])}};
  }
  friend bool any_less(LaneQuad a, LaneQuad b) {
    return a.v[0] < b.v[0] || a.v[1] < b.v[1] || a.v[2] < b.v[2] || a.v[3] < b.v[3];
  }
#endif
};

}  // namespace palpate::simplify

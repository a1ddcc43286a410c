// Eight numbers in registers of AVX2, as matrix_lanes.h asks for them. No fused multiply-add: the bits have
// to be those of every other processor. Only sources whose name ends in _avx2.cpp include it.
#pragma once

#if defined(__x86_64__) && defined(__GNUC__)

#include <immintrin.h>

#include <cstddef>
#include <cstdint>

#ifndef PALPATE_LANES_TARGET
/// The instruction set of all that is included below.
#define PALPATE_LANES_TARGET __attribute__((target("avx2")))
#endif
#include "core/dynamics/tet_engine/matrix_lanes.h"

namespace palpate::dynamics {

/// Eight floats in one register.
struct EightFloats {
  using Number = float;

  __m256 v;

  PALPATE_LANES static EightFloats of(float all) { return {_mm256_set1_ps(all)}; }
  PALPATE_LANES static EightFloats load(const float* eight) { return {_mm256_loadu_ps(eight)}; }
  PALPATE_LANES void store(float* eight) const { _mm256_storeu_ps(eight, v); }
  PALPATE_LANES friend EightFloats operator+(const EightFloats& a, const EightFloats& b) {
    return {_mm256_add_ps(a.v, b.v)};
  }
  PALPATE_LANES friend EightFloats operator-(const EightFloats& a, const EightFloats& b) {
    return {_mm256_sub_ps(a.v, b.v)};
  }
  PALPATE_LANES friend EightFloats operator*(const EightFloats& a, const EightFloats& b) {
    return {_mm256_mul_ps(a.v, b.v)};
  }
  PALPATE_LANES friend EightFloats operator/(const EightFloats& a, const EightFloats& b) {
    return {_mm256_div_ps(a.v, b.v)};
  }
  PALPATE_LANES friend bool any_less(const EightFloats& a, const EightFloats& b) {
    return _mm256_movemask_ps(_mm256_cmp_ps(a.v, b.v, _CMP_LT_OQ)) != 0;
  }

  /// Rows a and b side by side.
  PALPATE_LANES static __m256 pair(const float* a, const float* b) {
    return _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_load_ps(a)), _mm_load_ps(b), 1);
  }
  PALPATE_LANES static Vec3Lanes<EightFloats> load_rows(const float* rows, const std::uint16_t* at) {
    const __m256 r04 = pair(rows + at[0], rows + at[4]);
    const __m256 r15 = pair(rows + at[1], rows + at[5]);
    const __m256 r26 = pair(rows + at[2], rows + at[6]);
    const __m256 r37 = pair(rows + at[3], rows + at[7]);
    const __m256 xy01 = _mm256_unpacklo_ps(r04, r15);
    const __m256 xy23 = _mm256_unpacklo_ps(r26, r37);
    const __m256 z01 = _mm256_unpackhi_ps(r04, r15);
    const __m256 z23 = _mm256_unpackhi_ps(r26, r37);
    return {{_mm256_shuffle_ps(xy01, xy23, 0x44)},
            {_mm256_shuffle_ps(xy01, xy23, 0xee)},
            {_mm256_shuffle_ps(z01, z23, 0x44)}};
  }
  PALPATE_LANES static void add(float* to, __m128 what) {
    _mm_store_ps(to, _mm_add_ps(_mm_load_ps(to), what));
  }
  PALPATE_LANES static void add_rows(float* rows, const std::uint16_t* at,
                                     const Vec3Lanes<EightFloats>& what) {
    const __m256 xy_even = _mm256_unpacklo_ps(what.x.v, what.y.v);  // x0 y0 x1 y1, x4 y4 x5 y5
    const __m256 xy_odd = _mm256_unpackhi_ps(what.x.v, what.y.v);   // x2 y2 x3 y3, x6 y6 x7 y7
    const __m256 z_even = _mm256_unpacklo_ps(what.z.v, _mm256_setzero_ps());
    const __m256 z_odd = _mm256_unpackhi_ps(what.z.v, _mm256_setzero_ps());
    const __m256 f04 = _mm256_shuffle_ps(xy_even, z_even, 0x44);
    const __m256 f15 = _mm256_shuffle_ps(xy_even, z_even, 0xee);
    const __m256 f26 = _mm256_shuffle_ps(xy_odd, z_odd, 0x44);
    const __m256 f37 = _mm256_shuffle_ps(xy_odd, z_odd, 0xee);
    add(rows + at[0], _mm256_castps256_ps128(f04));
    add(rows + at[1], _mm256_castps256_ps128(f15));
    add(rows + at[2], _mm256_castps256_ps128(f26));
    add(rows + at[3], _mm256_castps256_ps128(f37));
    add(rows + at[4], _mm256_extractf128_ps(f04, 1));
    add(rows + at[5], _mm256_extractf128_ps(f15, 1));
    add(rows + at[6], _mm256_extractf128_ps(f26, 1));
    add(rows + at[7], _mm256_extractf128_ps(f37, 1));
  }
};

/// Eight doubles in two registers.
struct EightDoubles {
  using Number = double;

  __m256d low;
  __m256d high;

  PALPATE_LANES static EightDoubles of(double all) { return {_mm256_set1_pd(all), _mm256_set1_pd(all)}; }
  PALPATE_LANES static EightDoubles load(const double* eight) {
    return {_mm256_loadu_pd(eight), _mm256_loadu_pd(eight + 4)};
  }
  PALPATE_LANES void store(double* eight) const {
    _mm256_storeu_pd(eight, low);
    _mm256_storeu_pd(eight + 4, high);
  }
  PALPATE_LANES friend EightDoubles operator+(const EightDoubles& a, const EightDoubles& b) {
    return {_mm256_add_pd(a.low, b.low), _mm256_add_pd(a.high, b.high)};
  }
  PALPATE_LANES friend EightDoubles operator-(const EightDoubles& a, const EightDoubles& b) {
    return {_mm256_sub_pd(a.low, b.low), _mm256_sub_pd(a.high, b.high)};
  }
  PALPATE_LANES friend EightDoubles operator*(const EightDoubles& a, const EightDoubles& b) {
    return {_mm256_mul_pd(a.low, b.low), _mm256_mul_pd(a.high, b.high)};
  }
  PALPATE_LANES friend EightDoubles operator/(const EightDoubles& a, const EightDoubles& b) {
    return {_mm256_div_pd(a.low, b.low), _mm256_div_pd(a.high, b.high)};
  }
  PALPATE_LANES friend EightDoubles min(const EightDoubles& a, const EightDoubles& b) {
    return {_mm256_min_pd(a.low, b.low), _mm256_min_pd(a.high, b.high)};
  }
  PALPATE_LANES friend EightDoubles max(const EightDoubles& a, const EightDoubles& b) {
    return {_mm256_max_pd(a.low, b.low), _mm256_max_pd(a.high, b.high)};
  }
  PALPATE_LANES friend EightDoubles sqrt(const EightDoubles& a) {
    return {_mm256_sqrt_pd(a.low), _mm256_sqrt_pd(a.high)};
  }
  PALPATE_LANES friend bool any_less(const EightDoubles& a, const EightDoubles& b) {
    return _mm256_movemask_pd(_mm256_or_pd(_mm256_cmp_pd(a.low, b.low, _CMP_LT_OQ),
                                           _mm256_cmp_pd(a.high, b.high, _CMP_LT_OQ))) != 0;
  }

  struct Columns {
    __m256d x;
    __m256d y;
    __m256d z;
    __m256d w;
  };
  PALPATE_LANES static Columns turn(__m256d a, __m256d b, __m256d c, __m256d d) {
    const __m256d even_ab = _mm256_unpacklo_pd(a, b);  // a0 b0 a2 b2
    const __m256d odd_ab = _mm256_unpackhi_pd(a, b);   // a1 b1 a3 b3
    const __m256d even_cd = _mm256_unpacklo_pd(c, d);
    const __m256d odd_cd = _mm256_unpackhi_pd(c, d);
    return {_mm256_permute2f128_pd(even_ab, even_cd, 0x20), _mm256_permute2f128_pd(odd_ab, odd_cd, 0x20),
            _mm256_permute2f128_pd(even_ab, even_cd, 0x31), _mm256_permute2f128_pd(odd_ab, odd_cd, 0x31)};
  }
  template <typename Place>
  PALPATE_LANES static Columns turn_rows(const double* rows, const Place* at) {
    return turn(_mm256_loadu_pd(rows + at[0]), _mm256_loadu_pd(rows + at[1]), _mm256_loadu_pd(rows + at[2]),
                _mm256_loadu_pd(rows + at[3]));
  }
  template <typename Place>
  PALPATE_LANES static Vec3Lanes<EightDoubles> load_rows(const double* rows, const Place* at) {
    const Columns low = turn_rows(rows, at);
    const Columns high = turn_rows(rows, at + 4);
    return {{low.x, high.x}, {low.y, high.y}, {low.z, high.z}};
  }
  template <typename Place>
  PALPATE_LANES static RowLanes<EightDoubles> load_whole_rows(const double* rows, const Place* at) {
    const Columns low = turn_rows(rows, at);
    const Columns high = turn_rows(rows, at + 4);
    return {{{low.x, high.x}, {low.y, high.y}, {low.z, high.z}}, {low.w, high.w}};
  }
  template <typename Place>
  PALPATE_LANES static void store_four(double* rows, const Place* at, const Columns& what) {
    _mm256_storeu_pd(rows + at[0], what.x);
    _mm256_storeu_pd(rows + at[1], what.y);
    _mm256_storeu_pd(rows + at[2], what.z);
    _mm256_storeu_pd(rows + at[3], what.w);
  }
  template <typename Place>
  PALPATE_LANES static void store_whole_rows(double* rows, const Place* at,
                                             const RowLanes<EightDoubles>& what) {
    store_four(rows, at, turn(what.xyz.x.low, what.xyz.y.low, what.xyz.z.low, what.w.low));
    store_four(rows, at + 4, turn(what.xyz.x.high, what.xyz.y.high, what.xyz.z.high, what.w.high));
  }
  PALPATE_LANES static void add(double* to, __m256d what) {
    _mm256_storeu_pd(to, _mm256_add_pd(_mm256_loadu_pd(to), what));
  }
  PALPATE_LANES static void add_four(double* rows, const std::uint16_t* at, const Columns& what) {
    add(rows + at[0], what.x);
    add(rows + at[1], what.y);
    add(rows + at[2], what.z);
    add(rows + at[3], what.w);
  }
  PALPATE_LANES static void add_rows(double* rows, const std::uint16_t* at,
                                     const Vec3Lanes<EightDoubles>& what) {
    add_four(rows, at, turn(what.x.low, what.y.low, what.z.low, _mm256_setzero_pd()));
    add_four(rows, at + 4, turn(what.x.high, what.y.high, what.z.high, _mm256_setzero_pd()));
  }
};

}  // namespace palpate::dynamics

#endif

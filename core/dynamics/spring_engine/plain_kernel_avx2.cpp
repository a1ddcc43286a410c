// Eight springs at a time with AVX2. Functions carry their instruction set themselves, so that nothing else
// of the library needs it. No fused multiply-add: the bits have to be those of every other processor.
#include "core/base/error.h"
#include "core/dynamics/spring_engine/plain_kernel.h"

#if defined(__x86_64__) && defined(__GNUC__)

#include <immintrin.h>

#define PALPATE_AVX2 __attribute__((target("avx2")))
#define PALPATE_AVX2_INLINE __attribute__((target("avx2"), always_inline)) inline

namespace palpate::dynamics {
namespace {

/// What eight springs need for their forces: d, coordinate by coordinate, r, 1 / r^2 and c (w . d).
struct Ready {
  __m256 dx;
  __m256 dy;
  __m256 dz;
  __m256 root;
  __m256 inverse_sq;
  __m256 damper;
};

/// Forces on the first ends of springs 0 and 4, 1 and 5, 2 and 6, 3 and 7.
struct Forces {
  __m256 f04;
  __m256 f15;
  __m256 f26;
  __m256 f37;
};

/// Four rows (x, y, z, 0, vx, vy, vz, 0) to (x of all, vx of all), the same with y and with z.
struct Halves {
  __m256 x;
  __m256 y;
  __m256 z;
};
PALPATE_AVX2_INLINE Halves turn(__m256 r0, __m256 r1, __m256 r2, __m256 r3) {
  const __m256 xy01 = _mm256_unpacklo_ps(r0, r1);
  const __m256 xy23 = _mm256_unpacklo_ps(r2, r3);
  const __m256 z01 = _mm256_unpackhi_ps(r0, r1);
  const __m256 z23 = _mm256_unpackhi_ps(r2, r3);
  return {_mm256_shuffle_ps(xy01, xy23, 0x44), _mm256_shuffle_ps(xy01, xy23, 0xee),
          _mm256_shuffle_ps(z01, z23, 0x44)};
}

PALPATE_AVX2_INLINE __m256 row(const float* particles, std::size_t four_places) {
  return _mm256_load_ps(particles + 2 * four_places);
}

/// (a0 b0 + a2 b2) + a1 b1, as Lanes::sums has it.
PALPATE_AVX2_INLINE __m256 dot(__m256 ax, __m256 ay, __m256 az, __m256 bx, __m256 by, __m256 bz) {
  return _mm256_add_ps(_mm256_add_ps(_mm256_mul_ps(ax, bx), _mm256_mul_ps(az, bz)), _mm256_mul_ps(ay, by));
}

/// Differences of position and velocity of four springs, a row each.
struct Rows {
  __m256 d0;
  __m256 d1;
  __m256 d2;
  __m256 d3;
};

PALPATE_AVX2_INLINE Rows fan_rows(const std::uint16_t* b, const float* own, std::uint16_t hub) {
  const __m256 at = row(own, hub);
  return {_mm256_sub_ps(row(own, b[0]), at), _mm256_sub_ps(row(own, b[1]), at),
          _mm256_sub_ps(row(own, b[2]), at), _mm256_sub_ps(row(own, b[3]), at)};
}

PALPATE_AVX2_INLINE __m256 across_row(const AcrossGroup<float>& group, std::size_t i, const float* own,
                                      const float* all) {
  return _mm256_sub_ps(row(all, 4 * static_cast<std::size_t>(group.b[i])), row(own, group.a[i]));
}

PALPATE_AVX2_INLINE Ready prepare(const GroupConstants<float>& group, const Rows& r, const Rows& s,
                                  __m256& least_sq) {
  const Halves low = turn(r.d0, r.d1, r.d2, r.d3);
  const Halves high = turn(s.d0, s.d1, s.d2, s.d3);
  const __m256 dx = _mm256_permute2f128_ps(low.x, high.x, 0x20);
  const __m256 dy = _mm256_permute2f128_ps(low.y, high.y, 0x20);
  const __m256 dz = _mm256_permute2f128_ps(low.z, high.z, 0x20);
  const __m256 length_sq = dot(dx, dy, dz, dx, dy, dz);
  const __m256 approach =
      dot(dx, dy, dz, _mm256_permute2f128_ps(low.x, high.x, 0x31),
          _mm256_permute2f128_ps(low.y, high.y, 0x31), _mm256_permute2f128_ps(low.z, high.z, 0x31));
  least_sq = _mm256_min_ps(least_sq, length_sq);
  const __m256 safe_sq = _mm256_max_ps(length_sq, _mm256_set1_ps(1e-36F));
  return {dx,
          dy,
          dz,
          _mm256_sqrt_ps(safe_sq),
          _mm256_div_ps(_mm256_set1_ps(1.0F), safe_sq),
          _mm256_mul_ps(_mm256_loadu_ps(group.damping.data()), approach)};
}

PALPATE_AVX2_INLINE Ready prepare_inside(const InsideGroup<float>& group, const float* own,
                                         __m256& least_sq) {
  return prepare(group, fan_rows(group.b.data(), own, group.hub[0]),
                 fan_rows(group.b.data() + 4, own, group.hub[1]), least_sq);
}

PALPATE_AVX2_INLINE Ready prepare_across(const AcrossGroup<float>& group, const float* own, const float* all,
                                         __m256& least_sq) {
  return prepare(group,
                 {across_row(group, 0, own, all), across_row(group, 1, own, all),
                  across_row(group, 2, own, all), across_row(group, 3, own, all)},
                 {across_row(group, 4, own, all), across_row(group, 5, own, all),
                  across_row(group, 6, own, all), across_row(group, 7, own, all)},
                 least_sq);
}

PALPATE_AVX2_INLINE Forces pull(const GroupConstants<float>& group, const Ready& at) {
  const __m256 inverse = _mm256_mul_ps(at.root, at.inverse_sq);
  const __m256 spring = _mm256_sub_ps(_mm256_loadu_ps(group.stiffness.data()),
                                      _mm256_mul_ps(_mm256_loadu_ps(group.pull.data()), inverse));
  const __m256 damper = _mm256_mul_ps(at.damper, at.inverse_sq);
  const __m256 factor = _mm256_add_ps(spring, damper);
  const __m256 fx = _mm256_mul_ps(factor, at.dx);
  const __m256 fy = _mm256_mul_ps(factor, at.dy);
  const __m256 fz = _mm256_mul_ps(factor, at.dz);
  const __m256 xy_even = _mm256_unpacklo_ps(fx, fy);  // x0 y0 x1 y1, x4 y4 x5 y5
  const __m256 xy_odd = _mm256_unpackhi_ps(fx, fy);   // x2 y2 x3 y3, x6 y6 x7 y7
  const __m256 z_even = _mm256_unpacklo_ps(fz, _mm256_setzero_ps());
  const __m256 z_odd = _mm256_unpackhi_ps(fz, _mm256_setzero_ps());
  return {_mm256_shuffle_ps(xy_even, z_even, 0x44), _mm256_shuffle_ps(xy_even, z_even, 0xee),
          _mm256_shuffle_ps(xy_odd, z_odd, 0x44), _mm256_shuffle_ps(xy_odd, z_odd, 0xee)};
}

PALPATE_AVX2_INLINE void add(float* to, __m128 what) {
  _mm_store_ps(to, _mm_add_ps(_mm_load_ps(to), what));
}
PALPATE_AVX2_INLINE void take(float* from, __m128 what) {
  _mm_store_ps(from, _mm_sub_ps(_mm_load_ps(from), what));
}
PALPATE_AVX2_INLINE void add_inside(const InsideGroup<float>& group, const Forces& f, float* force) {
  const __m256 sum = _mm256_add_ps(_mm256_add_ps(f.f04, f.f15), _mm256_add_ps(f.f26, f.f37));
  take(force + group.b[0], _mm256_castps256_ps128(f.f04));
  take(force + group.b[1], _mm256_castps256_ps128(f.f15));
  take(force + group.b[2], _mm256_castps256_ps128(f.f26));
  take(force + group.b[3], _mm256_castps256_ps128(f.f37));
  add(force + group.hub[0], _mm256_castps256_ps128(sum));
  take(force + group.b[4], _mm256_extractf128_ps(f.f04, 1));
  take(force + group.b[5], _mm256_extractf128_ps(f.f15, 1));
  take(force + group.b[6], _mm256_extractf128_ps(f.f26, 1));
  take(force + group.b[7], _mm256_extractf128_ps(f.f37, 1));
  add(force + group.hub[1], _mm256_extractf128_ps(sum, 1));
}

PALPATE_AVX2_INLINE void add_across(const AcrossGroup<float>& group, const Forces& f, float* force) {
  add(force + group.a[0], _mm256_castps256_ps128(f.f04));
  add(force + group.a[1], _mm256_castps256_ps128(f.f15));
  add(force + group.a[2], _mm256_castps256_ps128(f.f26));
  add(force + group.a[3], _mm256_castps256_ps128(f.f37));
  add(force + group.a[4], _mm256_extractf128_ps(f.f04, 1));
  add(force + group.a[5], _mm256_extractf128_ps(f.f15, 1));
  add(force + group.a[6], _mm256_extractf128_ps(f.f26, 1));
  add(force + group.a[7], _mm256_extractf128_ps(f.f37, 1));
}

/// The next group's roots and quotients are on their way while a group's forces are added.
PALPATE_AVX2 float add_all(const BlockSprings<float>& springs, float* force) {
  const float* all = springs.all->x.data();
  const float* own = all + 8 * springs.first;
  __m256 least_sq = _mm256_set1_ps(1.0F);
  const InsideGroup<float>* inside = springs.inside.data();
  if (!springs.inside.empty()) {
    const std::size_t last = springs.inside.size() - 1;
    Ready now = prepare_inside(inside[0], own, least_sq);
    for (std::size_t g = 0; g < last; ++g) {
      fetch_ahead(inside + g + kGroupsAhead);
      fetch_ahead(reinterpret_cast<const char*>(inside + g + kGroupsAhead) + 64);
      const Ready next = prepare_inside(inside[g + 1], own, least_sq);
      add_inside(inside[g], pull(inside[g], now), force);
      now = next;
    }
    add_inside(inside[last], pull(inside[last], now), force);
  }
  const AcrossGroup<float>* across = springs.across.data();
  if (!springs.across.empty()) {
    const std::size_t last = springs.across.size() - 1;
    Ready now = prepare_across(across[0], own, all, least_sq);
    for (std::size_t g = 0; g < last; ++g) {
      const Ready next = prepare_across(across[g + 1], own, all, least_sq);
      add_across(across[g], pull(across[g], now), force);
      now = next;
    }
    add_across(across[last], pull(across[last], now), force);
  }
  __m128 least = _mm_min_ps(_mm256_castps256_ps128(least_sq), _mm256_extractf128_ps(least_sq, 1));
  least = _mm_min_ps(least, _mm_movehl_ps(least, least));
  return _mm_cvtss_f32(_mm_min_ss(least, _mm_shuffle_ps(least, least, 1)));
}

}  // namespace

float add_spring_forces_avx2(const BlockSprings<float>& springs, float* force) {
  return add_all(springs, force);
}

}  // namespace palpate::dynamics

#else

namespace palpate::dynamics {

float add_spring_forces_avx2(const BlockSprings<float>&, float*) {
  throw ContractError("this build has no AVX2");
}

}  // namespace palpate::dynamics

#endif

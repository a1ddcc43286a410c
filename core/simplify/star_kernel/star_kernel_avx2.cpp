// Eight tets at a time with AVX2. Functions carry their instruction set themselves, so that nothing else of
// the library needs it. No fused multiply-add: the bits have to be those of every other processor.
#include "core/base/error.h"
#include "core/simplify/star_kernel/star_kernel.h"

#if defined(__x86_64__) && defined(__GNUC__)

#include <immintrin.h>

#define PALPATE_STAR_TARGET __attribute__((target("avx2")))
#include "core/simplify/star_kernel/star_lanes.h"

namespace palpate::simplify {
namespace {

/// Eight lanes as star_lanes.h asks for them.
struct StarEight {
  static constexpr std::size_t kWidth = 8;

  __m256 v;

  PALPATE_STAR_LANES static StarEight of(float all) { return {_mm256_set1_ps(all)}; }
  PALPATE_STAR_LANES static StarEight load(const float* eight) { return {_mm256_loadu_ps(eight)}; }
  PALPATE_STAR_LANES void store(float* eight) const { _mm256_storeu_ps(eight, v); }
  PALPATE_STAR_LANES FloatLanes low() const { return {_mm256_castps256_ps128(v)}; }
  PALPATE_STAR_LANES FloatLanes high() const { return {_mm256_extractf128_ps(v, 1)}; }
  PALPATE_STAR_LANES friend StarEight operator+(const StarEight& a, const StarEight& b) {
    return {_mm256_add_ps(a.v, b.v)};
  }
  PALPATE_STAR_LANES friend StarEight operator-(const StarEight& a, const StarEight& b) {
    return {_mm256_sub_ps(a.v, b.v)};
  }
  PALPATE_STAR_LANES friend StarEight operator*(const StarEight& a, const StarEight& b) {
    return {_mm256_mul_ps(a.v, b.v)};
  }
  PALPATE_STAR_LANES friend StarEight operator/(const StarEight& a, const StarEight& b) {
    return {_mm256_div_ps(a.v, b.v)};
  }
  PALPATE_STAR_LANES friend StarEight min(const StarEight& a, const StarEight& b) {
    return {_mm256_min_ps(a.v, b.v)};
  }
  PALPATE_STAR_LANES friend StarEight max(const StarEight& a, const StarEight& b) {
    return {_mm256_max_ps(a.v, b.v)};
  }
  PALPATE_STAR_LANES friend StarEight sqrt(const StarEight& a) { return {_mm256_sqrt_ps(a.v)}; }
  /// A rounded root of a rounded square is the magnitude to the bit, unless the square leaves the range of
  /// normal numbers.
  PALPATE_STAR_LANES friend StarEight root_of_square(const StarEight& x, const StarEight& square) {
    const __m256 is_normal = _mm256_and_ps(_mm256_cmp_ps(square.v, _mm256_set1_ps(1e-30F), _CMP_GE_OQ),
                                           _mm256_cmp_ps(square.v, _mm256_set1_ps(1e30F), _CMP_LE_OQ));
    if (_mm256_movemask_ps(is_normal) != 0xff) return {_mm256_sqrt_ps(square.v)};
    return {_mm256_andnot_ps(_mm256_set1_ps(-0.0F), x.v)};
  }
  PALPATE_STAR_LANES friend bool any_less(const StarEight& a, const StarEight& b) {
    return _mm256_movemask_ps(_mm256_cmp_ps(a.v, b.v, _CMP_LT_OQ)) != 0;
  }

  PALPATE_STAR_LANES friend unsigned which_positive(const StarEight& a) {
    return static_cast<unsigned>(_mm256_movemask_ps(_mm256_cmp_ps(a.v, _mm256_setzero_ps(), _CMP_GT_OQ)));
  }

  /// The first half of a and the second of b.
  PALPATE_STAR_LANES friend StarEight halves(const StarEight& a, const StarEight& b) {
    return {_mm256_blend_ps(a.v, b.v, 0xf0)};
  }

  /// x, y, z and a zero of two points side by side.
  PALPATE_STAR_LANES static __m256 load_pair(const Vec3& first, const Vec3& second, __m256d origin,
                                             __m256d unit) {
    const __m256i three = _mm256_set_epi64x(0, -1, -1, -1);  // what lies behind the last point is not ours
    const __m256d p = _mm256_maskload_pd(&first.x, three);
    const __m256d q = _mm256_maskload_pd(&second.x, three);
    const __m128 low = _mm256_cvtpd_ps(_mm256_mul_pd(_mm256_sub_pd(p, origin), unit));
    const __m128 high = _mm256_cvtpd_ps(_mm256_mul_pd(_mm256_sub_pd(q, origin), unit));
    return _mm256_insertf128_ps(_mm256_castps128_ps256(low), high, 1);
  }
  PALPATE_STAR_LANES static LaneVec<StarEight> load_points(const StarTriangle* base, std::size_t corner,
                                                           const Vec3& origin, double unit) {
    const __m256d from = _mm256_set_pd(0.0, origin.z, origin.y, origin.x);
    const __m256d by = _mm256_set1_pd(unit);
    const __m256 r04 = load_pair(*base[0][corner], *base[4][corner], from, by);
    const __m256 r15 = load_pair(*base[1][corner], *base[5][corner], from, by);
    const __m256 r26 = load_pair(*base[2][corner], *base[6][corner], from, by);
    const __m256 r37 = load_pair(*base[3][corner], *base[7][corner], from, by);
    const __m256 xy01 = _mm256_unpacklo_ps(r04, r15);
    const __m256 xy23 = _mm256_unpacklo_ps(r26, r37);
    const __m256 z01 = _mm256_unpackhi_ps(r04, r15);
    const __m256 z23 = _mm256_unpackhi_ps(r26, r37);
    return {{_mm256_shuffle_ps(xy01, xy23, 0x44)},
            {_mm256_shuffle_ps(xy01, xy23, 0xee)},
            {_mm256_shuffle_ps(z01, z23, 0x44)}};
  }
};

PALPATE_STAR_TARGET void pack(const StarTriangle* base, std::size_t size, const Vec3& origin, double unit,
                              float* blocks) {
  pack_lanes<StarEight>(base, size, origin, unit, blocks);
}

/// The points of the ring at eight places.
PALPATE_STAR_LANES LaneVec<StarEight> take(const LaneVec<StarEight>& ring, const std::int32_t* at) {
  const __m256i places = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(at));
  return {{_mm256_permutevar8x32_ps(ring.x.v, places)},
          {_mm256_permutevar8x32_ps(ring.y.v, places)},
          {_mm256_permutevar8x32_ps(ring.z.v, places)}};
}

PALPATE_STAR_TARGET void pack_ring(const RingPoints& ring, std::size_t count, const Vec3& origin, double unit,
                                   float* blocks) {
  const RingTriangles& triangles = ring_triangles(count);
  std::array<StarTriangle, kBlockTriangles> base{};
  for (std::size_t i = 0; i < kBlockTriangles; ++i) base[i][0] = ring[i];
  const LaneVec<StarEight> points = StarEight::load_points(base.data(), 0, origin, unit);
  for (std::size_t i = 0; i < triangles.size; i += kBlockTriangles) {
    store_triangles(take(points, triangles.corner[0].data() + i),
                    take(points, triangles.corner[1].data() + i),
                    take(points, triangles.corner[2].data() + i), blocks + 12 * i);
  }
}

PALPATE_STAR_TARGET std::uint64_t find_positive(const float* blocks, std::size_t size, const StarApex& a,
                                                const StarApex& b) {
  return find_positive_lanes<StarEight>(blocks, size, a, b);
}

PALPATE_STAR_TARGET bool are_surely_positive(const float* blocks, std::size_t size, const StarApex& apex) {
  return are_surely_positive_lanes<StarEight>(blocks, size, apex);
}

PALPATE_STAR_TARGET void score_both(const float* blocks, const StarApex& a, const StarApex& b,
                                    float* scores) {
  const LaneVec<StarEight> at{halves(StarEight::of(a.x), StarEight::of(b.x)),
                              halves(StarEight::of(a.y), StarEight::of(b.y)),
                              halves(StarEight::of(a.z), StarEight::of(b.z))};
  score_at<SeenFrom::kBoth, StarEight>(at, a, blocks).store(scores);
}

template <SeenFrom kSide>
PALPATE_STAR_TARGET void score(const float* blocks, std::size_t size, const StarApex& apex, float* scores) {
  score_all_lanes<kSide, StarEight>(blocks, size, apex, scores);
}

PALPATE_STAR_TARGET StarFigures evaluate(const float* blocks, std::size_t size, const StarApex& apex,
                                         float gain_offset, float bound, float* scores) {
  return evaluate_lanes<StarEight>(blocks, size, apex, gain_offset, bound, scores);
}

}  // namespace

const StarKernel kStarKernelAvx2{pack,
                                 pack_ring,
                                 find_positive,
                                 are_surely_positive,
                                 score_both,
                                 score<SeenFrom::kFront>,
                                 score<SeenFrom::kBehind>,
                                 evaluate};

}  // namespace palpate::simplify

#else

namespace palpate::simplify {
namespace {

[[noreturn]] void refuse() {
  throw ContractError("this build has no AVX2");
}

}  // namespace

const StarKernel kStarKernelAvx2{
    [](const StarTriangle*, std::size_t, const Vec3&, double, float*) { refuse(); },
    [](const RingPoints&, std::size_t, const Vec3&, double, float*) { refuse(); },
    [](const float*, std::size_t, const StarApex&, const StarApex&) -> std::uint64_t { refuse(); },
    [](const float*, std::size_t, const StarApex&) -> bool { refuse(); },
    [](const float*, const StarApex&, const StarApex&, float*) { refuse(); },
    [](const float*, std::size_t, const StarApex&, float*) { refuse(); },
    [](const float*, std::size_t, const StarApex&, float*) { refuse(); },
    [](const float*, std::size_t, const StarApex&, float, float, float*) -> StarFigures { refuse(); }};

}  // namespace palpate::simplify

#endif

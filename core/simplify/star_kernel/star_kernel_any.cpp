// Four tets at a time on every processor.
#include "core/base/processor.h"
#include "core/simplify/star_kernel/star_lanes.h"

namespace palpate::simplify {
namespace {

using Four = Lanes<float>;

/// Four lanes as star_lanes.h asks for them.
struct StarFour {
  static constexpr std::size_t kWidth = 4;

  Four v;

  static StarFour of(float all) { return {Four::of(all)}; }
  static StarFour load(const float* four) { return {Four::load(four)}; }
  void store(float* four) const { v.store(four); }
  Four low() const { return v; }
  friend StarFour operator+(const StarFour& a, const StarFour& b) { return {a.v + b.v}; }
  friend StarFour operator-(const StarFour& a, const StarFour& b) { return {a.v - b.v}; }
  friend StarFour operator*(const StarFour& a, const StarFour& b) { return {a.v * b.v}; }
  friend StarFour operator/(const StarFour& a, const StarFour& b) { return {a.v / b.v}; }
  friend StarFour min(const StarFour& a, const StarFour& b) { return {min(a.v, b.v)}; }
  friend StarFour max(const StarFour& a, const StarFour& b) { return {max(a.v, b.v)}; }
  friend StarFour sqrt(const StarFour& a) { return {sqrt(a.v)}; }
  friend StarFour root_of_square(const StarFour& /*x*/, const StarFour& square) { return sqrt(square); }
  friend bool any_less(const StarFour& a, const StarFour& b) { return any_less(a.v, b.v); }

  friend unsigned which_positive(const StarFour& a) {
    std::array<float, 4> lane{};
    a.store(lane.data());
    unsigned positive = 0;
    for (std::size_t i = 0; i < 4; ++i) positive |= (lane[i] > 0.0F ? 1U : 0U) << i;
    return positive;
  }

  static LaneVec<StarFour> load_points(const StarTriangle* base, std::size_t corner, const Vec3& origin,
                                       double unit) {
    std::array<std::array<float, 4>, 3> rows{};
    for (std::size_t i = 0; i < 4; ++i) {
      const Vec3& p = *base[i][corner];
      rows[0][i] = static_cast<float>((p.x - origin.x) * unit);
      rows[1][i] = static_cast<float>((p.y - origin.y) * unit);
      rows[2][i] = static_cast<float>((p.z - origin.z) * unit);
    }
    return {load(rows[0].data()), load(rows[1].data()), load(rows[2].data())};
  }
};

constexpr RingTriangles build_ring_triangles(std::size_t count) {
  RingTriangles result;
  for (std::size_t i = 0; i + 2 < count; ++i) {
    for (std::size_t k = i + 1; k + 1 < count; ++k) {
      for (std::size_t j = k + 1; j < count; ++j, ++result.size) {
        result.corner[0][result.size] = static_cast<std::int32_t>(i);
        result.corner[1][result.size] = static_cast<std::int32_t>(k);
        result.corner[2][result.size] = static_cast<std::int32_t>(j);
      }
    }
  }
  constexpr std::size_t kHalf = kBlockTriangles / 2;
  for (auto& corner : result.corner) {
    for (std::size_t lane = result.size; lane < corner.size(); ++lane) {
      const bool is_second = result.size <= kHalf && lane >= kHalf && lane < kHalf + result.size;
      corner[lane] = is_second ? corner[lane - kHalf] : corner[result.size - 1];
    }
  }
  return result;
}

void pack(const StarTriangle* base, std::size_t size, const Vec3& origin, double unit, float* blocks) {
  pack_lanes<StarFour>(base, size, origin, unit, blocks);
}

void pack_ring(const RingPoints& ring, std::size_t count, const Vec3& origin, double unit, float* blocks) {
  const RingTriangles& triangles = ring_triangles(count);
  std::array<StarTriangle, RingTriangles::kMostLanes> base{};
  for (std::size_t i = 0; i < base.size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) base[i][c] = ring[static_cast<std::size_t>(triangles.corner[c][i])];
  }
  pack(base.data(), std::max(triangles.size, kBlockTriangles), origin, unit, blocks);
}

std::uint64_t find_positive(const float* blocks, std::size_t size, const StarApex& a, const StarApex& b) {
  return find_positive_lanes<StarFour>(blocks, size, a, b);
}

bool are_surely_positive(const float* blocks, std::size_t size, const StarApex& apex) {
  return are_surely_positive_lanes<StarFour>(blocks, size, apex);
}

void score_both(const float* blocks, const StarApex& a, const StarApex& b, float* scores) {
  score_lanes<SeenFrom::kFront, StarFour>(a, blocks).store(scores);
  score_lanes<SeenFrom::kBehind, StarFour>(b, blocks + 4).store(scores + 4);
}

template <SeenFrom kSide>
void score(const float* blocks, std::size_t size, const StarApex& apex, float* scores) {
  score_all_lanes<kSide, StarFour>(blocks, size, apex, scores);
}

StarFigures evaluate(const float* blocks, std::size_t size, const StarApex& apex, float gain_offset,
                     float bound, float* scores) {
  return evaluate_lanes<StarFour>(blocks, size, apex, gain_offset, bound, scores);
}

}  // namespace

const StarKernel kStarKernel{pack,
                             pack_ring,
                             find_positive,
                             are_surely_positive,
                             score_both,
                             score<SeenFrom::kFront>,
                             score<SeenFrom::kBehind>,
                             evaluate};

const RingTriangles& ring_triangles(std::size_t count) {
  static constexpr std::array<RingTriangles, kLargestRing - 2> kTriangles = [] {
    std::array<RingTriangles, kLargestRing - 2> all{};
    for (std::size_t n = 3; n <= kLargestRing; ++n) all[n - 3] = build_ring_triangles(n);
    return all;
  }();
  return kTriangles.at(count - 3);
}

const StarKernel& star_kernel() {
  static const StarKernel& best = has_avx2() ? kStarKernelAvx2 : kStarKernel;
  return best;
}

}  // namespace palpate::simplify

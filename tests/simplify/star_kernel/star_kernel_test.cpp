// Both forms of the scores' arithmetic give the same bits, whatever they are asked.
#include "core/simplify/star_kernel/star_kernel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "core/base/processor.h"
#include "core/base/random.h"
#include "core/mesh/geometry.h"
#include "core/mesh/orientation.h"

namespace palpate::simplify {
namespace {

/// Bits, so that a zero of the other sign or a number that is none is told apart.
std::vector<std::uint32_t> bits_of(const std::vector<float>& numbers) {
  std::vector<std::uint32_t> bits(numbers.size());
  std::memcpy(bits.data(), numbers.data(), numbers.size() * sizeof(float));
  return bits;
}

Vec3 random_point(SplitMix64& random, double size) {
  const double x = random.uniform() - 0.5;
  const double y = random.uniform() - 0.5;
  return {size * x, size * y, size * (random.uniform() - 0.5)};
}

/// Points of every kind: usual ones, flat and needle-like sets, coincident ones, too large and too small
/// ones.
std::vector<Vec3> random_points(SplitMix64& random, std::size_t count) {
  constexpr std::array kSizes{1.0, 1.0, 1.0, 1e-8, 1e-20, 1e19, 1e30};
  const double size = kSizes[random.below(kSizes.size())];
  const double flat = random.below(4) == 0 ? 0.0 : (random.below(4) == 0 ? 1e-7 : 1.0);
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < count; ++i) {
    Vec3 p = random_point(random, size);
    p.z *= flat;
    points.push_back(i > 0 && random.below(50) == 0 ? points[random.below(i)] : p);
  }
  return points;
}

StarApex random_apex(SplitMix64& random, const Vec3& at) {
  return {static_cast<float>(at.x),
          static_cast<float>(at.y),
          static_cast<float>(at.z),
          static_cast<float>(random.uniform() * 20.0),
          0.5F,
          random.below(2) == 0 ? 0.0F : 0.2F};
}

/// What a kernel says of a star, all in a row.
std::vector<float> answers_on_star(const StarKernel& kernel, const std::vector<StarTriangle>& base,
                                   std::size_t size, const Vec3& origin, const StarApex& apex, float bound) {
  std::vector<float> blocks(kBlockFloats * base.size() / kBlockTriangles);
  kernel.pack(base.data(), size, origin, 0.5, blocks.data());
  std::vector<float> scores(base.size());
  std::vector<float> out;
  const auto keep = [&] {
    out.insert(out.end(), scores.begin(), scores.begin() + static_cast<std::ptrdiff_t>(size));
  };
  kernel.score(blocks.data(), size, apex, scores.data());
  keep();
  kernel.score_from_behind(blocks.data(), size, apex, scores.data());
  keep();
  const StarFigures all = kernel.evaluate(blocks.data(), size, apex, 0.1F, 2.0F * kWorstScore, scores.data());
  keep();
  out.push_back(static_cast<float>(all.worst));
  out.push_back(static_cast<float>(all.sum));
  out.push_back(static_cast<float>(all.sum - double{static_cast<float>(all.sum)}));
  const StarFigures some = kernel.evaluate(blocks.data(), size, apex, 0.1F, bound, scores.data());
  out.push_back(some.worst < double{bound} ? 1.0F : 0.0F);
  return out;
}

TEST(StarKernel, BothFormsScoreStarsWithTheSameBits) {
  if (!has_avx2()) GTEST_SKIP() << "no AVX2 here; the other form is all there is";
  SplitMix64 random(11);
  for (int round = 0; round < 4000; ++round) {
    SCOPED_TRACE(round);
    const std::size_t size = 1 + random.below(40);
    const std::vector<Vec3> points = random_points(random, 3 * size);
    std::vector<StarTriangle> base;
    for (std::size_t i = 0; i < size; ++i)
      base.push_back({&points[3 * i], &points[3 * i + 1], &points[3 * i + 2]});
    while (base.size() % kBlockTriangles != 0) base.push_back(base.back());
    const StarApex apex = random_apex(random, points[random.below(points.size())]);
    const auto bound = static_cast<float>(random.uniform() * 0.1);
    const Vec3 origin = points[0];
    ASSERT_EQ(bits_of(answers_on_star(kStarKernel, base, size, origin, apex, bound)),
              bits_of(answers_on_star(kStarKernelAvx2, base, size, origin, apex, bound)));
  }
}

/// A star around a point near `origin`, each tet with a volume of about `height` of the greatest coordinate's
/// cube, with either sign where that is small.
struct AlmostFlatStar {
  Vec3 origin;
  Vec3 apex;
  std::vector<Vec3> points;
  std::vector<StarTriangle> base;
  std::size_t size = 0;
};

AlmostFlatStar random_almost_flat_star(SplitMix64& random, double height) {
  AlmostFlatStar star;
  const double far = random.below(2) == 0 ? 0.0 : 1000.0;
  star.origin = random_point(random, far);
  star.apex = star.origin + random_point(random, 2.0);  // far from the origin: the more is rounded
  star.size = random.below(2) == 0 ? 1 : 1 + random.below(30);
  star.points.reserve(3 * star.size);
  for (std::size_t i = 0; i < star.size; ++i) {
    const Vec3 u = star.origin + random_point(random, 2.0) - star.apex;
    const Vec3 v = star.origin + random_point(random, 2.0) - star.apex;
    Vec3 normal = cross(u, v);
    normal = (1.0 / std::max(length(normal), 1e-3)) * normal;
    const double up =
        height * (random.below(star.size + 1) == 0 ? random.uniform() - 0.5 : 1.0 + random.uniform());
    const Vec3 w = random.uniform() * u + random.uniform() * v + up * normal;
    for (const Vec3& p : {u, v, w}) star.points.push_back(star.apex + p);
  }
  star.base.resize((star.size + kBlockTriangles - 1) / kBlockTriangles * kBlockTriangles);
  for (std::size_t i = 0; i < star.base.size(); ++i) {
    const Vec3* const first = &star.points[3 * std::min(i, star.size - 1)];
    star.base[i] = {first, first + 1, first + 2};
  }
  return star;
}

TEST(StarKernel, WhatIsSurelyPositiveIsPositive) {
  constexpr double kUnit = 0.5;
  SplitMix64 random(20261130);
  std::size_t sure = 0;
  std::size_t not_positive = 0;
  for (int n = 0; n < 40000; ++n) {
    const double height = std::pow(10.0, -8.0 * random.uniform());
    const AlmostFlatStar star = random_almost_flat_star(random, height);
    const Vec3 at = kUnit * (star.apex - star.origin);
    const StarApex apex{
        static_cast<float>(at.x), static_cast<float>(at.y), static_cast<float>(at.z), 1.0F, 0.5F, 0.2F};
    std::vector<float> blocks(kBlockFloats * star.base.size() / kBlockTriangles);
    const auto ask = [&](const StarKernel& kernel) {
      kernel.pack(star.base.data(), star.size, star.origin, kUnit, blocks.data());
      return kernel.are_surely_positive(blocks.data(), star.size, apex);
    };
    const bool is_sure = ask(kStarKernel);
    if (has_avx2()) {
      ASSERT_EQ(ask(kStarKernelAvx2), is_sure) << n;
    }
    bool is_positive = true;
    for (std::size_t i = 0; i < star.size; ++i) {
      const auto& [a, b, c] = star.base[i];
      is_positive = is_positive && orientation(star.apex, *a, *b, *c) > 0;
    }
    if (is_sure) {
      ASSERT_TRUE(is_positive) << n;
    }
    sure += is_sure ? 1U : 0U;
    not_positive += is_positive ? 0U : 1U;
  }
  EXPECT_GT(sure, 5000U);           // it is of use
  EXPECT_GT(not_positive, 10000U);  // and was tempted
}

struct RingAnswers {
  std::uint64_t positive = 0;
  std::vector<float> from_a;
  std::vector<float> from_b;
  std::vector<float> both;
};

RingAnswers answers_on_ring(const StarKernel& kernel, const RingPoints& ring, std::size_t count,
                            const StarApex& a, const StarApex& b) {
  const std::size_t size = ring_triangles(count).size;
  std::vector<float> blocks(kBlockFloats * RingTriangles::kMostLanes / kBlockTriangles);
  RingAnswers found;
  kernel.pack_ring(ring, count, *ring[0], 0.5, blocks.data());
  found.positive = kernel.find_positive(blocks.data(), size, a, b);
  for (auto* const scores : {&found.from_a, &found.from_b}) scores->resize(RingTriangles::kMostLanes);
  kernel.score(blocks.data(), size, a, found.from_a.data());
  kernel.score_from_behind(blocks.data(), size, b, found.from_b.data());
  found.from_a.resize(size);
  found.from_b.resize(size);
  if (size > kBlockTriangles / 2) return found;
  std::vector<float> both(kBlockTriangles);
  kernel.score_both(blocks.data(), a, b, both.data());
  for (const std::size_t half : {std::size_t{0}, kBlockTriangles / 2})
    for (std::size_t t = 0; t < size; ++t) found.both.push_back(both[half + t]);
  return found;
}

TEST(StarKernel, BothFormsSeeRingsTheSameAndFromBothSidesAsOneByOne) {
  SplitMix64 random(12);
  std::size_t positive = 0;
  for (int round = 0; round < 4000; ++round) {
    SCOPED_TRACE(round);
    const std::size_t count = 3 + random.below(kLargestRing - 2);
    const std::vector<Vec3> points = random_points(random, count + 2);
    RingPoints ring{};
    for (std::size_t i = 0; i < ring.size(); ++i) ring[i] = &points[std::min(i, count - 1)];
    const StarApex a = random_apex(random, points[count]);
    StarApex b = random_apex(random, points[count + 1]);
    b.inverse_six_ideal = a.inverse_six_ideal;  // one edge, one scale
    b.mean_ratio_weight = a.mean_ratio_weight;
    const RingAnswers found = answers_on_ring(kStarKernel, ring, count, a, b);
    for (std::size_t t = 0; t < found.from_a.size(); ++t) {
      const bool is_positive = (found.positive >> t & 1U) != 0U;
      positive += is_positive ? 1U : 0U;
      if (found.from_a[t] > 0.0F && found.from_b[t] > 0.0F) {
        EXPECT_TRUE(is_positive) << t;
      }
    }
    const auto expect_both = [&](const RingAnswers& answers) {
      if (answers.both.empty()) return;
      std::vector<float> one_by_one = answers.from_a;
      one_by_one.insert(one_by_one.end(), answers.from_b.begin(), answers.from_b.end());
      ASSERT_EQ(bits_of(answers.both), bits_of(one_by_one));
    };
    expect_both(found);
    if (!has_avx2()) continue;
    const RingAnswers fast = answers_on_ring(kStarKernelAvx2, ring, count, a, b);
    expect_both(fast);
    ASSERT_EQ(found.positive, fast.positive);
    ASSERT_EQ(bits_of(found.from_a), bits_of(fast.from_a));
    ASSERT_EQ(bits_of(found.from_b), bits_of(fast.from_b));
  }
  EXPECT_GT(positive, 1000U);
}

TEST(StarKernel, ThereIsATriangleForEachThreeOfARing) {
  for (std::size_t count = 3; count <= kLargestRing; ++count) {
    const RingTriangles& triangles = ring_triangles(count);
    EXPECT_EQ(triangles.size, count * (count - 1) * (count - 2) / 6);
    for (std::size_t t = 0; t < triangles.size; ++t) {
      EXPECT_LT(triangles.corner[0][t], triangles.corner[1][t]);
      EXPECT_LT(triangles.corner[1][t], triangles.corner[2][t]);
    }
  }
}

}  // namespace
}  // namespace palpate::simplify

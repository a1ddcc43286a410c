#include "core/base/random.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <set>
#include <vector>

namespace palpate {
namespace {

TEST(SplitMix64, GivesThePublishedSequence) {
  // The first outputs of the reference generator for the seed 1234567.
  SplitMix64 random(1234567);
  EXPECT_EQ(random.next(), 6457827717110365317ULL);
  EXPECT_EQ(random.next(), 3203168211198807973ULL);
  EXPECT_EQ(random.next(), 9817491932198370423ULL);
  EXPECT_EQ(random.next(), 4593380528125082431ULL);
  EXPECT_EQ(random.next(), 16408922859458223821ULL);
}

TEST(SplitMix64, DependsOnTheSeedAlone) {
  SplitMix64 a(7);
  SplitMix64 b(7);
  SplitMix64 c(8);
  bool differs = false;
  for (int i = 0; i < 100; ++i) {
    const std::uint64_t bits = a.next();
    EXPECT_EQ(bits, b.next());
    differs = differs || bits != c.next();
  }
  EXPECT_TRUE(differs);
}

TEST(SplitMix64, UniformHasTheMomentsOfTheUniformDistribution) {
  constexpr int kCount = 1000000;
  SplitMix64 random(3);
  double sum = 0.0;
  double sum_sq = 0.0;
  for (int i = 0; i < kCount; ++i) {
    const double u = random.uniform();
    ASSERT_GE(u, 0.0);
    ASSERT_LT(u, 1.0);
    sum += u;
    sum_sq += u * u;
  }
  // Five standard errors: sd(u) = sqrt(1/12), sd(u^2) = sqrt(4/45).
  const double root = std::sqrt(static_cast<double>(kCount));
  EXPECT_NEAR(sum / kCount, 0.5, 5.0 * std::sqrt(1.0 / 12.0) / root);
  EXPECT_NEAR(sum_sq / kCount, 1.0 / 3.0, 5.0 * std::sqrt(4.0 / 45.0) / root);
}

TEST(SplitMix64, BelowIsUniform) {
  constexpr std::uint64_t kBound = 7;
  constexpr int kCount = 700000;
  SplitMix64 random(11);
  std::array<int, kBound> seen{};
  for (int i = 0; i < kCount; ++i) {
    const std::uint64_t value = random.below(kBound);
    ASSERT_LT(value, kBound);
    ++seen[value];
  }
  const double expected = static_cast<double>(kCount) / kBound;
  double chi_sq = 0.0;
  for (const int n : seen) chi_sq += (n - expected) * (n - expected) / expected;
  EXPECT_LT(chi_sq, 22.46);  // 6 degrees of freedom, p = 0.001
}

TEST(SplitMix64, BelowHasNoBiasForHugeBounds) {
  // Without rejection, the lower half of {0, ..., 3 * 2^62 - 1} would come up twice as often in its first
  // third.
  constexpr std::uint64_t kBound = 3ULL << 62U;
  constexpr int kCount = 300000;
  SplitMix64 random(5);
  int in_first_third = 0;
  for (int i = 0; i < kCount; ++i) {
    const std::uint64_t value = random.below(kBound);
    ASSERT_LT(value, kBound);
    if (value < kBound / 3) ++in_first_third;
  }
  const double sd = std::sqrt(kCount * (1.0 / 3.0) * (2.0 / 3.0));
  EXPECT_NEAR(in_first_third, kCount / 3.0, 5.0 * sd);
}

TEST(SplitMix64, BelowOneIsZero) {
  SplitMix64 random(1);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(random.below(1), 0U);
}

TEST(Shuffle, PermutesAndRepeats) {
  std::vector<int> items(1000);
  std::iota(items.begin(), items.end(), 0);
  const std::vector<int> sorted = items;
  std::vector<int> again = items;
  SplitMix64 random(9);
  shuffle(std::span<int>(items), random);
  SplitMix64 same_seed(9);
  shuffle(std::span<int>(again), same_seed);
  EXPECT_EQ(items, again);
  EXPECT_NE(items, sorted);
  std::sort(items.begin(), items.end());
  EXPECT_EQ(items, sorted);
}

TEST(Shuffle, ReachesEveryOrderEquallyOften) {
  constexpr int kCount = 60000;
  SplitMix64 random(2);
  std::array<int, 64> seen{};
  for (int i = 0; i < kCount; ++i) {
    std::array<int, 3> items{0, 1, 2};
    shuffle(std::span<int>(items), random);
    ++seen[16 * items[0] + 4 * items[1] + items[2]];
  }
  double chi_sq = 0.0;
  int orders = 0;
  for (const int n : seen) {
    if (n == 0) continue;
    ++orders;
    chi_sq += (n - kCount / 6.0) * (n - kCount / 6.0) / (kCount / 6.0);
  }
  EXPECT_EQ(orders, 6);
  EXPECT_LT(chi_sq, 20.52);  // 5 degrees of freedom, p = 0.001
}

TEST(Shuffle, LeavesShortSpansAlone) {
  SplitMix64 random(2);
  shuffle(std::span<int>(), random);
  std::array<int, 1> one{42};
  shuffle(std::span<int>(one), random);
  EXPECT_EQ(one[0], 42);
}

}  // namespace
}  // namespace palpate

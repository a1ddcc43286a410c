#include "experiments/rounds/round_order.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

namespace palpate::experiments {
namespace {

TEST(RoundOrder, EveryCaseOnceAndTheSameForTheSameSeed) {
  const std::vector<Case> cases(37);
  std::vector<std::size_t> all(cases.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  for (int repeat = 0; repeat < 20; ++repeat) {
    const auto order = order_round(cases, 7, repeat);
    EXPECT_THAT(order, testing::UnorderedElementsAreArray(all));
    EXPECT_EQ(order, order_round(cases, 7, repeat));
    EXPECT_NE(order, order_round(cases, 8, repeat));
    EXPECT_NE(order, order_round(cases, 7, repeat + 1));
    EXPECT_NE(order, order_round(cases, 8, repeat + 1)) << "neighbouring seeds do not share rounds";
  }
  EXPECT_TRUE(order_round({}, 1, 0).empty());
}

TEST(RoundOrder, EveryOrderIsEquallyLikely) {
  const std::vector<Case> cases(3);
  std::map<std::vector<std::size_t>, int> seen;
  constexpr int kRounds = 6000;
  for (int repeat = 0; repeat < kRounds; ++repeat) ++seen[order_round(cases, 1, repeat)];
  ASSERT_EQ(seen.size(), 6U);
  // Binomial(6000, 1/6): mean 1000, four standard deviations.
  const double allowance = 4.0 * std::sqrt(kRounds * (1.0 / 6.0) * (5.0 / 6.0));
  for (const auto& [order, count] : seen) EXPECT_NEAR(count, kRounds / 6.0, allowance);
}

TEST(RoundOrder, WhatIsNeededComesBefore) {
  std::vector<Case> cases(12);
  for (std::size_t i = 1; i < 6; ++i) cases[i].coarser = i - 1;  // a chain
  for (std::size_t i = 7; i < 12; ++i) cases[i].tets_of = 6;
  bool was_random = false;
  for (int repeat = 0; repeat < 50; ++repeat) {
    const auto order = order_round(cases, 3, repeat);
    std::vector<std::size_t> place(order.size());
    for (std::size_t i = 0; i < order.size(); ++i) place[order[i]] = i;
    for (std::size_t i = 1; i < 6; ++i) EXPECT_LT(place[i - 1], place[i]);
    for (std::size_t i = 7; i < 12; ++i) EXPECT_LT(place[6], place[i]);
    was_random = was_random || place[6] > place[0];
  }
  EXPECT_TRUE(was_random);
}

}  // namespace
}  // namespace palpate::experiments

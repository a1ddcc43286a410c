#include "experiments/contests/engine/motion_returns.h"

#include <gtest/gtest.h>

#include <cmath>

namespace palpate::experiments {
namespace {

/// Two tools, let go at 1 s and 5 s; the second comes at 4 s; the end is at 8 s.
reference::MotionProblem two_tools() {
  reference::MotionProblem problem;
  problem.duration_s = 8.0;
  reference::MotionLoad gravity;
  reference::MotionLoad second;
  second.part.supports.resize(1);
  second.from_s = 4.0;
  second.until_s = 5.0;
  reference::MotionLoad first = second;
  first.from_s = 0.0;
  first.until_s = 1.0;
  problem.loads = {gravity, second, first};
  return problem;
}

/// Held at 2 mm while a tool is there, then falling as exp(-rate t).
std::vector<MotionLevel> levels(double rate_per_s, double end_s) {
  std::vector<MotionLevel> out;
  for (int k = 0; k <= static_cast<int>(std::lround(end_s / 0.01)); ++k) {
    const double t = 0.01 * k;
    const double since = t < 4.005 ? t - 1.0 : t - 5.0;
    const double share = since < 0.0 ? 1.0 : std::exp(-rate_per_s * since);
    out.push_back({t, 2e-3 * share, 1e-3 * share * share});
  }
  return out;
}

TEST(MotionReturns, EachIsMeasuredUntilTheNextLoadComes) {
  const std::vector<MotionReturn> returns = find_returns(two_tools(), levels(2.0, 8.0));
  ASSERT_EQ(returns.size(), 2U);
  EXPECT_EQ(returns[0].load, 2U);  // in the order of time
  EXPECT_EQ(returns[1].load, 1U);
  for (const MotionReturn& each : returns) {
    EXPECT_NEAR(each.end_s - each.released_s, 3.0, 1e-12);
    EXPECT_DOUBLE_EQ(each.released_m, 2e-3);
    EXPECT_NEAR(each.half_s, std::log(2.0) / 2.0, 0.01);
    EXPECT_NEAR(each.twentieth_s, std::log(20.0) / 2.0, 0.01);
  }
  EXPECT_NEAR(returns[1].error(), std::exp(-6.0), 1e-9);
  EXPECT_NEAR(returns[1].left_rms_ratio, std::exp(-12.0), 1e-12);
}

TEST(MotionReturns, WhatIsNotReachedIsNullAndWhatIsNotLetGoIsLeftOut) {
  const auto slow = returns_to_json(find_returns(two_tools(), levels(0.3, 8.0)));
  ASSERT_EQ(slow.size(), 2U);
  EXPECT_TRUE(slow[1].at("half_s").is_number());
  EXPECT_TRUE(slow[1].at("twentieth_s").is_null());
  EXPECT_NEAR(slow[1].at("error").get<double>(), std::exp(-0.9), 1e-9);
  EXPECT_EQ(find_returns(two_tools(), levels(2.0, 4.5)).size(), 1U);  // the run ended early
  EXPECT_TRUE(find_returns(two_tools(), {}).empty());
  reference::MotionProblem held = two_tools();
  for (reference::MotionLoad& load : held.loads) load.until_s.reset();
  EXPECT_TRUE(find_returns(held, levels(2.0, 8.0)).empty());
}

}  // namespace
}  // namespace palpate::experiments

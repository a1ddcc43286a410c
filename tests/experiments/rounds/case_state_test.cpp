#include "experiments/rounds/case_state.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>

#include "core/base/error.h"
#include "experiments/rounds/rest_time.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;

std::vector<double> counted(std::size_t n) {
  std::vector<double> values;
  for (std::size_t i = n; i > 0; --i) values.push_back(static_cast<double>(i));  // n ... 1
  return values;
}

TEST(MedianInterval, RanksAndChancesInClosedForm) {
  // 1 - 2 (1 + n + ...) / 2^n; the values are their own ranks.
  const auto nine = median_interval(counted(9));
  ASSERT_TRUE(nine);
  EXPECT_EQ(nine->low, 2.0);
  EXPECT_EQ(nine->high, 8.0);
  EXPECT_DOUBLE_EQ(nine->coverage, 1.0 - 2.0 * (1.0 + 9.0) / 512.0);
  const auto twelve = median_interval(counted(12));
  ASSERT_TRUE(twelve);
  EXPECT_EQ(twelve->low, 3.0);
  EXPECT_EQ(twelve->high, 10.0);
  EXPECT_DOUBLE_EQ(twelve->coverage, 1.0 - 2.0 * (1.0 + 12.0 + 66.0) / 4096.0);
  EXPECT_DOUBLE_EQ(median_interval(counted(6))->coverage, 1.0 - 2.0 / 64.0);
  for (std::size_t n = 0; n < 6; ++n) EXPECT_FALSE(median_interval(counted(n))) << n;
  EXPECT_DOUBLE_EQ(median_interval(counted(5), 0.9)->coverage, 1.0 - 2.0 / 32.0);
}

/// All 2^n ways in which n values can lie below and above the median, one by one.
TEST(MedianInterval, ChancesByEnumeration) {
  for (unsigned n = 6; n <= 14; ++n) {
    const auto found = median_interval(counted(n));
    ASSERT_TRUE(found);
    const auto rank = static_cast<int>(found->low);
    unsigned held = 0;
    unsigned held_further = 0;
    for (unsigned ways = 0; ways < (1U << n); ++ways) {
      const int below = std::popcount(ways);  // values below the median
      held += below >= rank && below <= static_cast<int>(n) - rank ? 1U : 0U;
      held_further += below >= rank + 1 && below <= static_cast<int>(n) - rank - 1 ? 1U : 0U;
    }
    EXPECT_DOUBLE_EQ(found->coverage, held / std::ldexp(1.0, static_cast<int>(n))) << n;
    EXPECT_GE(found->coverage, 0.95);
    EXPECT_LT(held_further / std::ldexp(1.0, static_cast<int>(n)), 0.95) << "the next ranks do not keep it";
  }
}

TEST(MedianInterval, ManyValues) {
  // Half the width tends to 1.96 sqrt(n) / 2 ranks.
  const auto found = median_interval(counted(10'000));
  ASSERT_TRUE(found);
  EXPECT_NEAR((found->high - found->low) / 2.0, 1.96 * 50.0, 1.0);
  EXPECT_GE(found->coverage, 0.95);
  EXPECT_THROW(median_interval(counted(10'001)), ContractError);
}

TEST(MedianInterval, RelativeWidth) {
  EXPECT_DOUBLE_EQ(relative_median_width(counted(9)), 6.0 / 5.0);
  EXPECT_TRUE(std::isinf(relative_median_width(counted(5))));
  EXPECT_EQ(relative_median_width({2.0, 2.0, 2.0, 2.0, 2.0, 2.0}), 0.0);
}

json repeat_of(int number, const json& kernel_s, bool warmup = false, const char* outcome = "accepted") {
  return {{"repeat", number}, {"kernel_s", kernel_s}, {"warmup", warmup}, {"outcome", outcome}};
}

constexpr RepeatBounds kUntilNarrow{6, 12, 0.1};

TEST(CaseState, EndsAsSoonAsItIsNarrow) {
  CaseState state;
  state.remember(repeat_of(0, 50.0, true), kUntilNarrow);  // a warm-up counts for nothing
  for (int i = 1; i <= 6; ++i) {
    EXPECT_TRUE(state.is_due(i, 1, kUntilNarrow));
    state.remember(repeat_of(i, i == 1 ? 1.2 : 1.0 + 0.01 * i), kUntilNarrow);
    EXPECT_EQ(state.end, RepeatsEnd::kNotYet);
    EXPECT_FALSE(state.is_due(i, 1, kUntilNarrow)) << "it is there";
  }
  // 1.02 to 1.06 and 1.2: of 7 values the interval is the whole range, of 9 the 2nd to the 8th.
  for (int i = 7; i <= 8; ++i) state.remember(repeat_of(i, 1.05), kUntilNarrow);
  EXPECT_EQ(state.end, RepeatsEnd::kNotYet);
  state.remember(repeat_of(9, 1.05), kUntilNarrow);
  EXPECT_EQ(state.end, RepeatsEnd::kNarrow);
  EXPECT_DOUBLE_EQ(state.width, (1.06 - 1.03) / 1.05);
  EXPECT_EQ(state.count_measured(), 9);
  EXPECT_FALSE(state.is_due(10, 1, kUntilNarrow));
}

TEST(CaseState, EndsAtTheLimitOrWithoutTimes) {
  CaseState wide;
  for (int i = 0; i < 12; ++i) {
    EXPECT_TRUE(wide.is_due(i, 0, kUntilNarrow));
    wide.remember(repeat_of(i, 1.0 + i), kUntilNarrow);
  }
  EXPECT_EQ(wide.end, RepeatsEnd::kLimit);
  EXPECT_FALSE(wide.is_due(12, 0, kUntilNarrow));
  CaseState crashed;
  for (int i = 0; i < 6; ++i) crashed.remember(repeat_of(i, nullptr, false, "crashed"), kUntilNarrow);
  EXPECT_EQ(crashed.end, RepeatsEnd::kNoTime);
  EXPECT_FALSE(crashed.is_due(6, 0, kUntilNarrow));
  CaseState closed;
  closed.remember(repeat_of(0, nullptr, false, "timed_out"), kUntilNarrow);
  EXPECT_FALSE(closed.is_due(1, 0, kUntilNarrow));
}

TEST(CaseState, WithoutAWidthThePlansNumberIsAll) {
  const RepeatBounds three{3, 3, std::nullopt};
  CaseState state;
  for (int i = 0; i < 3; ++i) state.remember(repeat_of(i, 1.0), three);
  EXPECT_EQ(state.end, RepeatsEnd::kAll);
  EXPECT_FALSE(state.is_due(3, 0, three));
}

TEST(CaseState, KeepsOfEachAnswerWhatALaterRepeatIsHeldAgainst) {
  const RepeatBounds four{4, 4, std::nullopt};
  const auto answer = [](int number, const char* hash, double tets, const char* ended) {
    json record = repeat_of(number, 1.0);
    record.update({{"output_hash", hash},
                   {"judge", {{"tets", tets}, {"valid", true}}},
                   {"report", {{"outcome", ended}}}});
    return record;
  };
  CaseState state;
  EXPECT_TRUE(state.earlier_answers().empty());
  state.remember(answer(0, "a", 7.0, "converged"), four);
  state.remember(answer(1, "a", 7.0, "converged"), four);
  state.remember(answer(2, "a", 8.0, "diverged"), four);
  json failed = answer(3, "b", 9.0, "converged");
  failed.update({{"outcome", "rejected"}, {"violations", {"too few"}}, {"tuned", {{"size", 2}}}});
  state.remember(failed, four);
  const std::vector<json> earlier = state.earlier_answers();
  ASSERT_EQ(earlier.size(), 3U) << "the second repeat is the first one's answer";
  EXPECT_EQ(earlier[0], json({{"output_hash", "a"},
                              {"report", {{"outcome", "converged"}}},
                              {"judge", {{"tets", 7.0}, {"valid", true}}}}));
  EXPECT_EQ(earlier[1].at("report").at("outcome"), "diverged");
  EXPECT_EQ(earlier[2].at("output_hash"), "b");
  EXPECT_EQ(state.tets, 7.0);
  EXPECT_EQ(state.tuned, json({{"size", 2}}));
  EXPECT_EQ(state.worst, "rejected");
  EXPECT_EQ(state.first_failure, "rejected: too few");
  state.drop_answers();
  EXPECT_TRUE(state.earlier_answers().empty());
  EXPECT_EQ(state.count_measured(), 4);
}

TEST(RestTime, IsWhatTheDueRepeatsTake) {
  RestTime rest;
  rest.add(3, 2.0);
  rest.add(2, -1.0);
  rest.add(0, 4.0);
  EXPECT_EQ(rest.repeats(), 5U);
  EXPECT_DOUBLE_EQ(rest.seconds(7.0), 3 * 2.0 + 2 * 3.0)
      << "a case that was not run is as long as the mean of those that were";
  rest.remove(2, -1.0);
  rest.add(1, 5.0);
  EXPECT_EQ(rest.repeats(), 4U);
  EXPECT_DOUBLE_EQ(rest.seconds(7.0), 3 * 2.0 + 5.0);
}

TEST(RestTime, WhereNoTimeIsKnownTheSittingSaysHowLongOneTakes) {
  RestTime rest;
  for (int i = 0; i < 3; ++i) rest.add(2, -1.0);
  rest.remove(2, -1.0);
  rest.add(1, -1.0);
  EXPECT_EQ(rest.repeats(), 5U);
  EXPECT_DOUBLE_EQ(rest.seconds(1.5), 5 * 1.5);
}

TEST(CaseState, WhatIsStated) {
  RunSettings run;
  run.repeats = 6;
  run.until_width = 0.1;
  run.most_repeats = 12;
  std::vector<Case> cases(3);
  for (std::size_t i = 0; i < cases.size(); ++i) cases[i].id = std::string(1, static_cast<char>('a' + i));
  cases[2].seed = 1;
  std::vector<CaseState> states(3);
  for (int i = 0; i < 6; ++i) states[0].remember(repeat_of(i, 1.0), repeat_bounds(run, cases[0]));
  json provenance;
  state_repeats(run, cases, states, provenance);
  EXPECT_EQ(provenance.at("repeats_of"), json({{"b", 12}, {"c", 12}})) << "b and c have not ended";
  EXPECT_EQ(provenance.at("repeats_ended"),
            json({{"a", {{"reason", "narrow"}, {"repeats", 6}, {"width", 0.0}}}}));
  run.seed_repeats = 2;  // then seeds are not prolonged
  state_repeats(run, cases, states, provenance);
  EXPECT_EQ(provenance.at("repeats_of"), json({{"b", 12}, {"c", 2}}));
}

}  // namespace
}  // namespace palpate::experiments

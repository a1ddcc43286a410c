// The bisection of an envelope against borders that are known, and the difference of two histories.
#include "experiments/envelope/envelope_search.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/base/error.h"
#include "experiments/trials/motion_trial.h"
#include "tests/support/scratch_folder.h"

namespace palpate::experiments {
namespace {

EnvelopeProbe probe_at(double factor, double border) {
  EnvelopeProbe probe;
  probe.factor = factor;
  if (factor > border) probe.ending = "error";
  return probe;
}

TEST(FindBorder, LiesBetweenWhatHoldsAndWhatDoesNot) {
  for (const double border : {1.0, 1.05, 1.5, 7.0, 63.0, 99.0}) {
    int asked = 0;
    const EnvelopeBorder found =
        find_border(probe_at(1.0, border), 100.0, [&](double factor) -> std::optional<EnvelopeProbe> {
          ++asked;
          return probe_at(factor, border);
        });
    ASSERT_TRUE(found.holds_to && found.fails_at) << border;
    EXPECT_LE(*found.holds_to, border);
    EXPECT_GT(*found.fails_at, border);
    EXPECT_LE(*found.fails_at / *found.holds_to, kEnvelopeResolution);
    EXPECT_TRUE(found.is_complete);
    EXPECT_LE(asked, 1 + std::ceil(std::log2(std::log(100.0) / std::log(kEnvelopeResolution))));
    EXPECT_TRUE(std::is_sorted(found.probes.begin(), found.probes.end(),
                               [](const auto& a, const auto& b) { return a.factor < b.factor; }));
  }
}

TEST(FindBorder, IsBroughtInNoFartherThanAskedFor) {
  for (const double resolution : {1.01, 1.5, 2.0, 11.0}) {
    int asked = 0;
    const auto probe = [&](double factor) -> std::optional<EnvelopeProbe> {
      ++asked;
      return probe_at(factor, 7.0);
    };
    const EnvelopeBorder found = find_border(probe_at(1.0, 7.0), 100.0, probe, resolution);
    EXPECT_LE(*found.fails_at / *found.holds_to, resolution);
    EXPECT_GT(*found.fails_at / *found.holds_to, std::sqrt(resolution));
    EXPECT_EQ(asked, 1 + std::ceil(std::log2(std::log(100.0) / std::log(resolution))));
  }
}

TEST(FindBorder, WhatHoldsEverywhereHasNoFailure) {
  const EnvelopeBorder found =
      find_border(probe_at(1.0, 1e9), 30.0, [](double factor) { return probe_at(factor, 1e9); });
  EXPECT_EQ(found.holds_to, 30.0);
  EXPECT_FALSE(found.fails_at);
  EXPECT_EQ(found.probes.size(), 2U);
}

TEST(FindBorder, WhatDoesNotHoldAsItIsIsNotLookedAtFurther) {
  const EnvelopeBorder found =
      find_border(probe_at(1.0, 0.5), 30.0, [](double) -> std::optional<EnvelopeProbe> {
        ADD_FAILURE() << "asked";
        return std::nullopt;
      });
  EXPECT_FALSE(found.holds_to);
  EXPECT_EQ(found.fails_at, 1.0);
}

TEST(FindBorder, WhereItIsStoppedTheBorderStaysWide) {
  int asked = 0;
  const EnvelopeBorder found =
      find_border(probe_at(1.0, 5.0), 100.0, [&](double factor) -> std::optional<EnvelopeProbe> {
        if (++asked == 3) return std::nullopt;
        return probe_at(factor, 5.0);
      });
  EXPECT_FALSE(found.is_complete);
  EXPECT_EQ(found.holds_to, 1.0);
  EXPECT_EQ(found.fails_at, 10.0);  // 100, then sqrt(1 x 100)
}

/// x(t) = size (t, 2 t) at `rows` + 1 times up to 1 s.
ProbeHistory straight_history(int rows, double size) {
  ProbeHistory history;
  for (int k = 0; k <= rows; ++k) {
    const double t = static_cast<double>(k) / rows;
    history.time_s.push_back(t);
    history.row.push_back({size * t, 2.0 * size * t});
  }
  return history;
}

TEST(HistoryDifference, OfStraightMotionsIsThatOfTheirSizes) {
  EXPECT_NEAR(history_difference(straight_history(10, 1.0), straight_history(7, 1.0)), 0.0, 1e-12);
  EXPECT_NEAR(history_difference(straight_history(10, 1.25), straight_history(7, 1.0)), 0.25, 1e-12);
  EXPECT_NEAR(history_difference(straight_history(3, 0.5), straight_history(40, 1.0)), 0.5, 1e-12);
}

TEST(HistoryDifference, NothingThatIsNoNumberPasses) {
  ProbeHistory broken = straight_history(10, 1.0);
  broken.row[4][1] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(history_difference(broken, straight_history(10, 1.0)), std::numeric_limits<double>::infinity());
  EXPECT_EQ(history_difference(straight_history(10, 1.0), straight_history(10, 0.0)),
            std::numeric_limits<double>::infinity());
  EXPECT_EQ(history_difference(straight_history(10, 0.0), straight_history(10, 0.0)), 0.0);
}

TEST(ProbeHistory, TheColumnsOfProbesAreReadByName) {
  const test::ScratchFolder folder;
  const auto file =
      folder.add("answer.json",
                 R"({"columns": ["probe_1_ux_m", "time_s", "other"], "rows": [[1, 0, 7], [null, 0.5, 7]]})");
  const ProbeHistory history = read_probe_history(file);
  EXPECT_THAT(history.time_s, testing::ElementsAre(0.0, 0.5));
  EXPECT_EQ(history.row[0], std::vector<double>{1.0});
  EXPECT_TRUE(std::isnan(history.row[1][0]));
  EXPECT_THROW(read_probe_history(folder.add("none.json", R"({"columns": ["time_s"], "rows": []})")),
               InputError);
  EXPECT_THROW(read_probe_history(
                   folder.add("short.json", R"({"columns": ["time_s", "probe_1_ux_m"], "rows": [[1]]})")),
               InputError);
}

}  // namespace
}  // namespace palpate::experiments

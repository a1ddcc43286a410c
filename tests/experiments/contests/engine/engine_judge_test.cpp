// What the judge computes from the files of the contest engine, and which files it refuses.
#include "experiments/contests/engine/engine_judge.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/base/error.h"
#include "tests/support/scratch_folder.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;
using testing::HasSubstr;

class EngineJudge : public testing::Test {
 protected:
  EngineJudge() {
    mesh_.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    mesh_.tets = {{0, 1, 2, 3}};
    problem_.duration_s = 2.0;
    reference::MotionLoad tool;
    tool.part.supports.resize(1);
    tool.until_s = 1.0;
    problem_.loads = {tool};
  }

  json judge(const json& file, const std::string& outcome = "completed") const {
    return judge_engine_file(problem_, mesh_, {{"outcome", outcome}},
                             folder_.add("answer.json", file.dump()));
  }
  std::string refusal(const json& file) const {
    try {
      judge(file);
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  }

  /// Pressed by 8 mm until 1 s, then a half, a quarter ... every 0.2 s.
  static json replay() {
    json rows = json::array();
    for (int k = 0; k <= 10; ++k) {
      const double time = 0.2 * k;
      const double share = k <= 5 ? 1.0 : std::exp2(5 - k);
      rows.push_back({time, 0.008 * share, 0.004 * share * share, 0.5 + 0.1 * k});
    }
    const std::vector<double> still(12, 0.0);
    std::vector<double> turned(12, 0.0);
    turned[11] = -2.0;  // the fourth vertex goes through the face of the others
    return {{"schema", "palpate/engine/1"},
            {"kind", "replay"},
            {"columns", {"time_s", "largest_displacement_m", "rms_displacement_m", "largest_speed_m_s"}},
            {"rows", rows},
            {"frames",
             {{{"time_s", 0.0}, {"displacement_m", still}}, {{"time_s", 2.0}, {"displacement_m", turned}}}}};
  }

  test::ScratchFolder folder_;
  TetMesh mesh_;
  reference::MotionProblem problem_;
};

TEST_F(EngineJudge, ReturnsSpeedsAndInvertedTetsComeFromTheFile) {
  const json judged = judge(replay());
  EXPECT_EQ(judged.at("kind"), "replay");
  EXPECT_TRUE(judged.at("valid").get<bool>());
  ASSERT_EQ(judged.at("returns").size(), 1U);
  EXPECT_NEAR(judged.at("return_error").get<double>(), 1.0 / 32.0, 1e-12);
  EXPECT_NEAR(judged.at("return_rms_error").get<double>(), std::exp2(-10), 1e-12);
  EXPECT_NEAR(judged.at("half_return_s").get<double>(), 0.2, 1e-12);
  EXPECT_NEAR(judged.at("twentieth_return_s").get<double>(), 1.0, 1e-12);
  EXPECT_DOUBLE_EQ(judged.at("largest_displacement_m").get<double>(), 0.008);
  EXPECT_DOUBLE_EQ(judged.at("largest_speed_in_rows_m_s").get<double>(), 1.5);
  EXPECT_EQ(judged.at("inverted_in_frames_most"), 1);
}

TEST_F(EngineJudge, AFigureThatOneReturnDidNotReachIsLeftOut) {
  json file = replay();
  for (json& row : file["rows"]) row[1] = 0.008;
  const json judged = judge(file);
  EXPECT_DOUBLE_EQ(judged.at("return_error").get<double>(), 1.0);
  EXPECT_FALSE(judged.contains("half_return_s"));
}

TEST_F(EngineJudge, TheSlowestDecayIsThatOfTheSlowestRate) {
  json file = {{"schema", "palpate/engine/1"},
               {"kind", "rest"},
               {"columns", {"rate_per_s", "frequency_per_s"}},
               {"rows", {{-4.0, 0.0}, {-0.5, 3.0}}}};
  EXPECT_DOUBLE_EQ(judge(file).at("slowest_decay_s").get<double>(), 2.0);
  file["rows"] = {{0.0, 3.0}};  // does not fall
  EXPECT_FALSE(judge(file).contains("slowest_decay_s"));
  file["rows"] = json::array();
  EXPECT_FALSE(judge(file).contains("slowest_decay_s"));
}

TEST_F(EngineJudge, TheHeldForceIsAMeanAndIsHeldAgainstTheReference) {
  const json file = {{"schema", "palpate/engine/1"},
                     {"kind", "ticks"},
                     {"columns", {"time_s", "fx_n", "fy_n", "fz_n"}},
                     {"rows", json::array()},
                     {"held_forces_n", {{0.0, 0.0, -1.0}, {0.0, 0.0, -2.0}}}};
  json judged = judge(file);
  EXPECT_DOUBLE_EQ(judged.at("held_force_size_n").get<double>(), 1.5);
  EXPECT_DOUBLE_EQ(judged.at("held_force_spread_n").get<double>(), 0.5);
  compare_force({{0.0, 0.0, -1.2}, 0.01}, judged);
  EXPECT_NEAR(judged.at("force_error").get<double>(), 0.25, 1e-12);
  EXPECT_FALSE(judged.at("reference_too_coarse").get<bool>());
  compare_force({{0.0, 0.0, -1.2}, 0.2}, judged);
  EXPECT_TRUE(judged.at("reference_too_coarse").get<bool>());
}

TEST_F(EngineJudge, WhatDidNotComeToItsEndIsNoMotion) {
  const json judged = judge(json::array(), "diverged");
  EXPECT_FALSE(judged.at("valid").get<bool>());
  EXPECT_THAT(judged.at("findings").dump(), HasSubstr("diverged"));
}

TEST_F(EngineJudge, BrokenFilesAreRefusedWithWhatIsWrong) {
  json file = replay();
  file["rows"].erase(10);
  EXPECT_THAT(refusal(file), HasSubstr("rows to 2.0 s"));
  file = replay();
  file["rows"][3][0] = 0.2;
  EXPECT_THAT(refusal(file), HasSubstr("times that rise from 0"));
  file = replay();
  file["rows"][3][1] = nullptr;
  EXPECT_THAT(refusal(file), HasSubstr("a number"));
  file = replay();
  file["rows"][3].erase(3);
  EXPECT_THAT(refusal(file), HasSubstr("one cell a column"));
  file = replay();
  file["columns"][1] = "largest";
  EXPECT_THAT(refusal(file), HasSubstr("largest_displacement_m"));
  file = replay();
  file["frames"][1]["displacement_m"].erase(5);
  EXPECT_THAT(refusal(file), HasSubstr("12 numbers"));
  file = replay();
  file["kind"] = "reply";
  EXPECT_THAT(refusal(file), HasSubstr("replay, rest or ticks"));
  file["kind"] = "ticks";
  EXPECT_THAT(refusal(file), HasSubstr("held_forces_n"));
  EXPECT_THAT(refusal(json::array()), HasSubstr("an object"));
}

TEST_F(EngineJudge, ReportedFiguresAreNumbersAlone) {
  const json reported =
      reported_figures({{"ticks", 100}, {"tick_p50_s", nullptr}, {"speeds_cut", "many"}, {"x", 1}});
  EXPECT_EQ(reported, (json{{"ticks", 100}}));
}

}  // namespace
}  // namespace palpate::experiments

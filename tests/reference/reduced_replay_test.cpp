// reduced.modal_replay as the runner starts it: the motion of moving_reduced.modal, with what the contest
// engine asks for.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "reference/door/json_file.h"
#include "reference/door/moving_body.h"
#include "tests/support/moving_contestant.h"

namespace palpate::reference {
namespace {

using experiments::ContestantAnswer;
using nlohmann::json;
using testing::HasSubstr;

class ModalReplay : public test::MovingContestant {
 protected:
  /// A pad that comes, goes and comes again.
  ModalReplay() {
    MotionLoad pad = rod_.problem.loads[0];
    pad.until_s = 0.4;
    MotionLoad again = rod_.pad(3.0 * rod_.stiffness_n_m3(), test::PushedRod::kByM);
    again.from_s = 0.7;
    again.profile = {{0.7, 0.75}, {0.0, 1.0}, true};
    rod_.problem.loads = {pad, again};
    rod_.problem.samples = 250;
  }

  ContestantAnswer replay(const json& options) {
    MovingBody body;
    body.motion = rod_.problem;
    body.model.method = "springs.van_gelder";  // not used
    body.stepping.frames = 10;
    return starter_.run("reduced.modal_replay", rod_.mesh, moving_body_to_json(body), options);
  }

  test::PushedRod rod_;
};

TEST_F(ModalReplay, IsTheMotionOfTheContestOfMotions) {
  const json options{{"modes", 12}, {"elements", "p1"}, {"time_step_s", 2e-3}};
  const MotionHistory motion = move("moving_reduced.modal", rod_, options);
  const ContestantAnswer answer = replay(options);
  ASSERT_EQ(answer.outcome, "ok") << answer.message;
  const json file = read_json_file(answer.output);
  EXPECT_EQ(file.at("kind"), "replay");
  ASSERT_EQ(file.at("rows").size(), motion.rows.size());
  const json& columns = file.at("columns");
  for (std::size_t c = 0; c < motion.columns.size(); ++c) {
    const auto at = std::find(columns.begin(), columns.end(), motion.columns[c]);
    ASSERT_NE(at, columns.end()) << motion.columns[c];
    for (std::size_t k = 0; k < motion.rows.size(); ++k)
      EXPECT_EQ(file.at("rows")[k][static_cast<std::size_t>(at - columns.begin())].get<double>(),
                motion.rows[k][c])
          << k << motion.columns[c];
  }
  EXPECT_EQ(answer.report.at("outcome"), "completed");
  EXPECT_EQ(answer.report.at("holdings"), 3);  // each pad by itself, and none
  EXPECT_EQ(answer.report.at("inverted_tets_most"), 0);
  EXPECT_NEAR(answer.report.at("simulated_s").get<double>(), 1.0, 1e-12);
  EXPECT_EQ(file.at("frames").size(), 11U);
}

/// What is timed again is the motion's steps; where there is no time one step is taken.
TEST_F(ModalReplay, StepsAreTimedAgainAndEndWhereTheyAreAskedTo) {
  const ContestantAnswer timed = replay({{"modes", 5}, {"elements", "p1"}, {"timings", 3}});
  ASSERT_EQ(timed.outcome, "ok") << timed.message;
  ASSERT_EQ(timed.report.at("kernel_samples_s").size(), 3U);
  for (const json& seconds : timed.report.at("kernel_samples_s")) EXPECT_GT(seconds.get<double>(), 0.0);
  EXPECT_GT(timed.report.at("field_s").get<double>(), 0.0);
  EXPECT_GT(timed.report.at("setup_s").get<double>(), timed.report.at("field_s").get<double>());
  const ContestantAnswer plain = replay({{"modes", 5}, {"elements", "p1"}});
  EXPECT_EQ(timed.report.at("state_hash"), plain.report.at("state_hash"));
  EXPECT_EQ(read_json_file(timed.output), read_json_file(plain.output));
  const ContestantAnswer stopped = replay({{"modes", 5}, {"elements", "p1"}, {"stop_after_s", 1e-9}});
  ASSERT_EQ(stopped.outcome, "ok") << stopped.message;
  EXPECT_EQ(stopped.report.at("outcome"), "timed_out");
  EXPECT_EQ(stopped.report.at("steps"), 1);
  EXPECT_EQ(replay({{"setup_only", true}}).report.at("outcome"), "set_up");
}

TEST_F(ModalReplay, TheFarthestVertexIsTheRodsEnd) {
  const json options{{"modes", 12}, {"elements", "p1"}, {"time_step_s", 2e-3}};
  const ContestantAnswer answer = replay(options);
  ASSERT_EQ(answer.outcome, "ok") << answer.message;
  const json file = read_json_file(answer.output);
  const auto place = [&](const char* name) {
    const json& columns = file.at("columns");
    return static_cast<std::size_t>(std::find(columns.begin(), columns.end(), name) - columns.begin());
  };
  // At rest under the pad the displacement runs straight from 0 to 3/4 of the pad's way.
  const json& held = file.at("rows")[100];
  EXPECT_NEAR(held[place("time_s")].get<double>(), 0.4, 1e-9);
  const double end = 0.75 * std::fabs(test::PushedRod::kByM);
  EXPECT_NEAR(held[place("largest_displacement_m")].get<double>(), end, 0.02 * end);
  EXPECT_NEAR(std::fabs(held[place("probe_1_ux_m")].get<double>()), end, 0.02 * end);
  // Seven layers of as many vertices: the mean square of k / 6 is 13 / 36.
  EXPECT_NEAR(held[place("rms_displacement_m")].get<double>(), std::sqrt(13.0 / 36.0) * end, 0.02 * end);
  EXPECT_EQ(file.at("rows")[0][place("largest_speed_m_s")], 0.0);
}

TEST_F(ModalReplay, WhatCannotBeIsRefusedAndWhatIsLargeIsSaid) {
  const ContestantAnswer unknown = replay({{"tick_s", 1e-3}});
  EXPECT_EQ(unknown.outcome, "bad_input");
  EXPECT_THAT(unknown.message, HasSubstr("tick_s"));
  rod_.problem.body.strain = StrainSize::kLarge;
  for (MotionLoad& load : rod_.problem.loads) load.part.strain = StrainSize::kLarge;
  EXPECT_THAT(replay({{"modes", 5}, {"elements", "p1"}}).notes,
              testing::Contains(HasSubstr("taken for small ones")));
  rod_.problem.body.held.pop_back();  // the left end: nothing holds the rod when the pad has gone
  const ContestantAnswer free = replay({{"modes", 5}});
  EXPECT_EQ(free.outcome, "bad_input");
  EXPECT_THAT(free.message, HasSubstr("left free"));
}

}  // namespace
}  // namespace palpate::reference

// moving_reduced.modal as the runner starts it: against closed forms and the elements that it reduces, and
// what it refuses.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "reference/door/motion_problem.h"
#include "tests/support/moving_contestant.h"
#include "tests/support/rod.h"

namespace palpate::reference {
namespace {

using experiments::ContestantAnswer;
using nlohmann::json;
using test::column;
using testing::HasSubstr;

class MovingModes : public test::MovingContestant {};

TEST_F(MovingModes, FrequenciesOfARodHeldAtOneEnd) {
  test::Rod rod(8);
  rod.hold_left();
  rod.problem.frequencies = 2;
  rod.problem.duration_s = 1e-3;
  move("moving_reduced.modal", rod, {{"modes", 5}});
  const double exact = rod.wave_speed_m_s() / (4.0 * test::Rod::kLengthM);
  EXPECT_NEAR(report_.at("frequencies_hz")[0].get<double>(), exact, 1e-4 * exact);
  EXPECT_NEAR(report_.at("frequencies_hz")[1].get<double>(), 3.0 * exact, 3e-3 * exact);
}

TEST_F(MovingModes, FollowsNewmarkOfTheSameElementsThroughAPadThatComesAndGoes) {
  test::Rod rod(6);
  rod.hold_left();
  rod.problem.damping_mass_per_s = 4.0;
  rod.problem.damping_stiffness_s = 1e-3;
  rod.problem.duration_s = 0.4;
  rod.problem.samples = 200;
  MotionLoad pad = rod.pad(3.0 * rod.modulus_pa() / test::Rod::kLengthM, -1e-3);
  pad.profile = {{0.0, 0.1}, {0.0, 1.0}, true};
  pad.until_s = 0.2;
  rod.problem.loads = {pad};
  const MotionHistory newmark = move("moving_fem.p2", rod, {{"time_step_s", 2e-4}});
  const MotionHistory modes = move("moving_reduced.modal", rod, {{"time_step_s", 1e-3}, {"modes", 25}});
  ASSERT_GT(modes.rows.size(), 100U);
  for (const char* name : {"probe_1_ux_m", "tool_1_fx_n", "total_j"}) {
    const std::vector<double> times = column(newmark, "time_s");
    const std::vector<double> truth = column(newmark, name);
    const std::vector<double> at = column(modes, "time_s");
    const std::vector<double> found = column(modes, name);
    double size = 0.0;
    for (const double value : truth) size = std::max(size, std::fabs(value));
    std::size_t compared = 0;
    for (std::size_t k = 0; k < at.size(); ++k) {
      for (std::size_t n = 0; n < times.size(); ++n) {
        if (std::fabs(times[n] - at[k]) > 1e-9) continue;
        EXPECT_NEAR(found[k], truth[n], 0.01 * size) << name << " at " << at[k];
        ++compared;
      }
    }
    EXPECT_GT(compared, 50U);
  }
}

TEST_F(MovingModes, ToolForceEndsAtTheStaticReactionAndAHeldEndFollowsItsProfile) {
  test::PushedRod rod;
  const double by = test::PushedRod::kByM;
  const double expected = rod.pad_force_n();
  EXPECT_NEAR(column(move("moving_reduced.modal", rod, {{"modes", 4}}), "tool_1_fx_n").back(), expected,
              1e-6 * std::fabs(expected));
  // The end held hard and moved: the reaction of the whole rod, and the end where it was put.
  MotionLoad hold = rod.empty_load();
  hold.part.held.push_back({rod.right(), {true, false, false}, {by, 0, 0}});
  hold.profile = rod.problem.loads[0].profile;
  rod.problem.loads = {hold};
  const MotionHistory held = move("moving_reduced.modal", rod, {{"modes", 4}});
  EXPECT_NEAR(column(held, "tool_1_fx_n").back(), rod.stiffness_n_m3() * by * test::Rod::kAreaM2, 1e-6);
  EXPECT_NEAR(column(held, "probe_1_ux_m").back(), by, 1e-12);
}

TEST_F(MovingModes, EnergyIsKeptWithoutDamping) {
  test::Rod rod(6);
  rod.hold_left();
  rod.problem.duration_s = 1.0;
  MotionLoad pull = rod.sine_force(2000.0);
  pull.profile = {{0.0, 0.1}, {0.0, 1.0}, true};
  pull.until_s = 0.2;
  rod.problem.loads = {pull};
  const MotionHistory history = move("moving_reduced.modal", rod, {{"modes", 10}, {"time_step_s", 2e-3}});
  const std::vector<double> times = column(history, "time_s");
  const std::vector<double> total = column(history, "total_j");
  double first = -1.0;
  for (std::size_t k = 0; k < times.size(); ++k) {
    if (times[k] < 0.2 + 1e-6) continue;
    if (first < 0.0) first = total[k];
    EXPECT_NEAR(total[k], first, 1e-9 * first);
  }
  EXPECT_GT(first, 0.0);
}

TEST_F(MovingModes, RefusesABodyThatIsLeftFreeInAPhase) {
  test::Rod rod(4);
  const ContestantAnswer answer =
      starter_.run("moving_reduced.modal", rod.mesh, motion_to_json(rod.problem), json::object());
  EXPECT_EQ(answer.outcome, "bad_input");
  EXPECT_THAT(answer.message, HasSubstr("left free"));
}

}  // namespace
}  // namespace palpate::reference

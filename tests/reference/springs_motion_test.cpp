// moving_springs.* and moving_smoothed.* as the runner starts them, on rods and cubes that are known.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/judge/motion/oscillation.h"
#include "experiments/contestants/contestant_run.h"
#include "reference/door/motion_problem.h"
#include "tests/support/angles.h"
#include "tests/support/moving_contestant.h"
#include "tests/support/rod.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;
using reference::MotionHistory;
using reference::MotionLoad;
using test::column;
using test::kPi;
using test::Rod;
using testing::HasSubstr;

class MovingSprings : public test::MovingContestant {};

/// Linear elements, no smoothing at all.
const json kLinearElements{{"theta", 0.0}, {"rest", "tet"}, {"domain", "tet"}};

// Lumped masses make the frequencies of a rod too low where consistent ones make them too high; the error
// falls as h^2.
TEST_F(MovingSprings, FrequenciesOfARodHeldAtOneEnd) {
  std::vector<double> errors;
  for (const int cells : {8, 16}) {
    Rod rod(cells);
    rod.hold_left();
    rod.problem.frequencies = 3;
    rod.problem.duration_s = 1e-3;
    move("moving_smoothed.blend", rod, kLinearElements);
    const double exact = rod.wave_speed_m_s() / (4.0 * Rod::kLengthM);
    errors.push_back(report_.at("frequencies_hz")[0].get<double>() / exact - 1.0);
    EXPECT_EQ(report_.at("frequencies_hz").size(), 3U);
  }
  EXPECT_LT(std::fabs(errors[1]), 5e-3);
  EXPECT_NEAR(std::log2(errors[0] / errors[1]), 2.0, 0.3);
}

TEST_F(MovingSprings, ToolForceEndsAtTheStaticReaction) {
  const test::PushedRod rod;
  const double expected = rod.pad_force_n();
  for (const char* integrator : {"symplectic_euler", "velocity_verlet", "runge_kutta_4"}) {
    json options = kLinearElements;
    options["integrator"] = integrator;
    const MotionHistory history = move("moving_smoothed.blend", rod, options);
    EXPECT_NEAR(column(history, "tool_1_fx_n").back(), expected, 1e-6 * std::fabs(expected)) << integrator;
    EXPECT_LT(report_.at("time_step_s"), report_.at("stable_step_s")) << integrator;
  }
}

// What damps the first mode as much decays as fast, whatever the model: zeta omega = (alpha + beta omega^2)
// / 2.
TEST_F(MovingSprings, DampingModelsAgreeInTheFirstMode) {
  Rod rod(8);
  rod.hold_left();
  MotionLoad pluck = rod.sine_force(1000.0);
  pluck.profile = {{0.0, 0.3}, {0.0, 1.0}, true};
  pluck.until_s = 0.3;
  rod.problem.loads = {pluck};
  rod.problem.damping_stiffness_s = 1e-3;
  rod.problem.damping_mass_per_s = 2.0;
  rod.problem.duration_s = 0.9;
  rod.problem.frequencies = 1;
  for (const char* damping : {"rayleigh", "springs", "vertices"}) {
    const MotionHistory history =
        move("moving_springs.van_gelder", rod, {{"damping", damping}, {"integrator", "velocity_verlet"}});
    const double omega = 2.0 * kPi * report_.at("frequencies_hz")[0].get<double>();
    const auto fit =
        judge::fit_oscillations(column(history, "time_s"), column(history, "probe_1_ux_m"), {0.3, 0.9}, 3);
    ASSERT_TRUE(fit);
    const judge::Oscillation& found = fit->oscillations[0];
    EXPECT_NEAR(found.frequency_hz, omega / (2.0 * kPi), 0.01 * found.frequency_hz) << damping;
    EXPECT_NEAR(found.decay_per_s, 0.5 * (2.0 + 1e-3 * omega * omega), 0.03 * found.decay_per_s) << damping;
    EXPECT_EQ(report_.at("spring_damping_n_s_per_m") > 0.0, std::string(damping) == "springs");
    EXPECT_EQ(report_.at("vertex_damping_n_s_per_m") > 0.0, std::string(damping) == "vertices");
  }
}

TEST_F(MovingSprings, PhasesEndWhereTheyAreToldTo) {
  Rod rod(4);
  rod.hold_left();
  MotionLoad pad = rod.pad(1e5, 1e-3);
  pad.until_s = 0.0777;
  rod.problem.loads = {pad};
  for (const char* integrator : {"symplectic_euler", "implicit_euler", "prefactored"}) {
    json options{{"integrator", integrator}, {"time_step_s", 5e-4}};
    if (options.at("integrator") == "prefactored")
      options.update({{"iterations", 2000}, {"tolerance", 1e-6}});
    const MotionHistory history = move("moving_springs.van_gelder", rod, options);
    const std::vector<double> time = column(history, "time_s");
    const std::vector<double> force = column(history, "tool_1_fx_n");
    EXPECT_EQ(time.back(), 0.2);
    for (std::size_t k = 0; k < time.size(); ++k) EXPECT_EQ(force[k] != 0.0, time[k] <= 0.0777) << time[k];
  }
}

TEST_F(MovingSprings, NeoHookeanTetrahedraMoveAsLinearOnesWhereStrainsAreSmall) {
  Rod rod(4);
  rod.hold_left();
  MotionLoad pull = rod.sine_force(20.0);
  pull.profile = {{0.0, 0.05}, {0.0, 1.0}, true};
  rod.problem.loads = {pull};
  const json linear{
      {"domain", "tet"}, {"theta", 1.0}, {"integrator", "backward_euler"}, {"time_step_s", 5e-3}};
  const std::vector<double> wanted = column(move("moving_smoothed.blend", rod, linear), "probe_1_ux_m");
  json swept = linear;
  swept.update(
      {{"law", "stable_neo_hookean"}, {"integrator", "xpbd"}, {"iterations", 20000}, {"tolerance", 1e-7}});
  const std::vector<double> found = column(move("moving_smoothed.blend", rod, swept), "probe_1_ux_m");
  ASSERT_EQ(found.size(), wanted.size());
  double off = 0.0;
  double size = 0.0;
  for (std::size_t k = 0; k < found.size(); ++k) {
    off = std::max(off, std::abs(found[k] - wanted[k]));
    size = std::max(size, std::abs(wanted[k]));
  }
  EXPECT_GT(size, 0.0);
  EXPECT_LT(off, 0.02 * size);  // strains of a percent
}

TEST_F(MovingSprings, WhatCannotBeIsRefused) {
  Rod rod(2);
  rod.hold_left();
  const auto refused = [&](const std::string& method, const json& options, const std::string& reason) {
    const ContestantAnswer answer = run(method, rod.mesh, rod.problem, options);
    EXPECT_EQ(answer.outcome, "bad_input") << reason;
    EXPECT_THAT(answer.message, HasSubstr(reason));
  };
  const std::string springs = "moving_springs.van_gelder";
  refused(springs, {{"integrator", "euler"}}, "symplectic_euler");
  refused(springs, {{"time_step_s", -1e-3}}, "time_step_s");
  refused(springs, {{"time_step_s", 1.0}}, "at most the stable step of symplectic_euler");
  refused(springs, {{"integrator", "implicit_euler"}}, "which has no bound");
  refused(springs, {{"integrator", "explicit_euler"}}, "a stable step of explicit_euler");
  refused(springs, {{"damping", "none"}}, "damping");
  refused(springs, {{"time_step_s", 1e-11}}, "at most 1e9 steps");
  refused(springs, {{"load_steps", 3}}, "load_steps");
  refused(springs, {{"integrator", "prefactored"}, {"time_step_s", 1e-3}, {"volume", "thesis"}},
          "a model that has an energy");
  refused("moving_smoothed.edge_node", {{"damping", "springs"}}, "a model without springs");
  rod.problem.frequencies = 1000;
  refused(springs, json::object(), "frequencies");
}

}  // namespace
}  // namespace palpate::experiments

// moving_fem.p1 and moving_fem.p2 as the runner starts them, held against rods and oscillators in closed
// form.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/mesh/shapes/shapes.h"
#include "core/mesh/topology.h"
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
using reference::MotionProblem;
using test::column;
using test::kPi;
using test::Rod;
using testing::HasSubstr;

/// Starts a method on a motion.
class MovingElements : public test::MovingContestant {
 protected:
  void SetUp() override {
    ASSERT_EQ(starter_.registry().find("moving_fem.p2")->contestant->unavailable(), "");
  }

  std::vector<double> frequencies(const std::string& method, Rod rod, std::size_t count) {
    rod.problem.frequencies = count;
    rod.problem.duration_s = 1e-3;
    move(method, rod);
    return report_.value("frequencies_hz", std::vector<double>(count));
  }
};

// f_k = (2 k - 1) c / (4 L). The error of omega falls as h^4 for P2 and as h^2 for P1.
TEST_F(MovingElements, FrequenciesOfARodHeldAtOneEnd) {
  for (const auto& [method, order, at_16] :
       {std::tuple{"moving_fem.p2", 4.0, 1e-4}, std::tuple{"moving_fem.p1", 2.0, 2e-2}}) {
    std::vector<std::vector<double>> found;
    for (const int cells : {8, 16}) {
      Rod rod(cells);
      rod.hold_left();
      found.push_back(frequencies(method, rod, 3));
    }
    for (std::size_t k = 0; k < 3; ++k) {
      const double exact =
          (2.0 * static_cast<double>(k) + 1.0) * Rod(1).wave_speed_m_s() / (4.0 * Rod::kLengthM);
      const double coarse = found[0][k] / exact - 1.0;
      const double fine = found[1][k] / exact - 1.0;
      EXPECT_GT(fine, 0.0) << "a Rayleigh quotient is never too low";
      EXPECT_LT(fine, at_16) << method << ", mode " << k;
      EXPECT_NEAR(std::log2(coarse / fine), order, 0.3) << method << ", mode " << k;
    }
  }
}

// An end on a support: (lambda + 2 mu) k tan(k L) = kappa.
TEST_F(MovingElements, FrequencyOnAnElasticSupport) {
  Rod rod(16);
  const double kappa = 0.7 * rod.modulus_pa() / Rod::kLengthM;
  const std::vector<Triangle> faces = rod.left();
  rod.problem.body.supports.push_back({{faces, std::vector<double>(faces.size(), 1.0)}, kappa, {}});
  double low = 0.0;
  double high = 0.5 * kPi;
  for (int k = 0; k < 100; ++k) {
    const double middle = 0.5 * (low + high);
    (middle * std::tan(middle) < 0.7 ? low : high) = middle;
  }
  const double exact = low * rod.wave_speed_m_s() / (2.0 * kPi * Rod::kLengthM);
  EXPECT_NEAR(frequencies("moving_fem.p2", rod, 1)[0], exact, 1e-5 * exact);
}

TEST_F(MovingElements, AFreeBodyHasSixMotionsOfFrequencyZero) {
  Rod rod(4);
  rod.problem.body.held.clear();
  const std::vector<double> found = frequencies("moving_fem.p2", rod, 7);
  for (std::size_t k = 0; k < 6; ++k) EXPECT_LT(found[k], 1e-3 * found[6]);
  EXPECT_GT(found[6], 1.0);
}

/// A rod that a force of its first mode's shape sets in motion: one damped oscillator.
struct OneMode {
  Rod rod{8};
  double omega = 0.0;  ///< of the discrete mode
  double decay = 0.0;  ///< zeta omega

  explicit OneMode(double discrete_hz, double stiffness_s, double mass_per_s)
      : omega(2.0 * kPi * discrete_hz) {
    rod.hold_left();
    rod.problem.loads.push_back(rod.sine_force(1000.0));
    rod.problem.damping_stiffness_s = stiffness_s;
    rod.problem.damping_mass_per_s = mass_per_s;
    decay = 0.5 * (mass_per_s + stiffness_s * omega * omega);
  }

  /// Of the static deflection, at `time`.
  double share_at(double time) const {
    const double damped = std::sqrt(omega * omega - decay * decay);
    return 1.0 -
           std::exp(-decay * time) * (std::cos(damped * time) + decay / damped * std::sin(damped * time));
  }

  double static_m() const { return 1000.0 / (1000.0 * omega * omega); }  // force over density x omega^2
};

// M q'' + (alpha M + beta K) q' + K q = f from rest: a decay with zeta = alpha / (2 omega) + beta omega / 2.
// What the mesh adds, higher modes, is a share of 2e-4. Newmark's own error falls as h^2.
TEST_F(MovingElements, OneModeRingsAndDecaysAsDampingSays) {
  Rod held(8);
  held.hold_left();
  const double discrete_hz = frequencies("moving_fem.p2", held, 1)[0];
  for (const auto& [stiffness_s, mass_per_s] : {std::pair{0.0, 0.0}, {1e-3, 4.0}}) {
    const OneMode mode(discrete_hz, stiffness_s, mass_per_s);
    std::vector<double> worst;
    for (const double step : {4e-3, 2e-3, 1e-3}) {
      const MotionHistory history =
          move("moving_fem.p2", mode.rod.mesh, mode.rod.problem, {{"time_step_s", step}});
      const std::vector<double> u = column(history, "probe_1_ux_m");
      worst.push_back(0.0);
      for (std::size_t k = 0; k < u.size(); ++k) {
        const double expected = mode.static_m() * mode.share_at(history.rows[k][0]);
        worst.back() = std::max(worst.back(), std::fabs(u[k] - expected) / mode.static_m());
      }
    }
    EXPECT_LT(worst[2], 5e-3) << stiffness_s << " " << mass_per_s;
    EXPECT_NEAR(std::log2(worst[0] / worst[1]), 2.0, 0.25);
    EXPECT_NEAR(std::log2(worst[1] / worst[2]), 2.0, 0.25);
  }
}

TEST_F(MovingElements, WithoutDampingTheEnergyStays) {
  OneMode mode(8.66, 0.0, 0.0);
  for (const auto& [method, solver] :
       {std::pair{"moving_fem.p1", "mumps"}, {"moving_fem.p2", "cg"}, {"moving_fem.p2", "mumps"}}) {
    const MotionHistory history =
        move(method, mode.rod.mesh, mode.rod.problem, {{"time_step_s", 2e-3}, {"solver", solver}});
    double most = 0.0;
    for (const double energy : column(history, "elastic_j")) most = std::max(most, energy);
    for (const double energy : column(history, "total_j")) EXPECT_NEAR(energy, 0.0, 1e-8 * most) << solver;
  }
}

// A pad pushes slowly against a damped rod: in the end springs in series, a fixed force.
TEST_F(MovingElements, ToolForceEndsAtTheStaticReaction) {
  test::PushedRod rod;
  const double by = test::PushedRod::kByM;
  const MotionLoad pad = rod.problem.loads[0];
  MotionLoad hand = rod.empty_load();
  hand.part.held.push_back({rod.right(), {true, false, false}, {by, 0.0, 0.0}});
  hand.profile = pad.profile;
  for (const char* method : {"moving_fem.p1", "moving_fem.p2"}) {
    for (const auto& [load, expected] :
         {std::pair{pad, rod.pad_force_n()}, std::pair{hand, rod.stiffness_n_m3() * by * Rod::kAreaM2}}) {
      rod.problem.loads = {load};
      const MotionHistory history = move(method, rod.mesh, rod.problem, {{"time_step_s", 5e-3}});
      EXPECT_NEAR(column(history, "tool_1_fx_n").back(), expected, 1e-6 * std::fabs(expected));
      EXPECT_NEAR(column(history, "tool_1_fy_n").back(), 0.0, 1e-6 * std::fabs(expected));
    }
    const MotionHistory led = move(method, rod.mesh, rod.problem, {{"time_step_s", 5e-3}});
    EXPECT_NEAR(column(led, "probe_1_ux_m").back(), by, 1e-15);
  }
}

// A load that lets go leaves a free oscillation about zero; its tool's force is zero from then on.
TEST_F(MovingElements, ALoadThatLetsGo) {
  Rod rod(6);
  rod.hold_left();
  MotionLoad pad = rod.pad(10.0 * rod.modulus_pa() / Rod::kLengthM, 1e-3);
  pad.profile = {{0.0, 0.1}, {0.0, 1.0}, true};
  pad.until_s = 0.13;
  rod.problem.loads = {pad};
  rod.problem.duration_s = 0.4;
  const MotionHistory history = move("moving_fem.p2", rod.mesh, rod.problem, {{"time_step_s", 1e-3}});
  const std::vector<double> time = column(history, "time_s");
  const std::vector<double> force = column(history, "tool_1_fx_n");
  const std::vector<double> total = column(history, "total_j");
  double released = 0.0;
  for (std::size_t k = 0; k < time.size(); ++k) {
    if (time[k] < 0.13 + 1e-9) continue;
    EXPECT_EQ(force[k], 0.0);
    if (released == 0.0) released = total[k];
    EXPECT_NEAR(total[k], released, 1e-8 * released);
  }
  EXPECT_GT(released, 0.0);
}

TEST_F(MovingElements, ARefinedMeshTakesSupportsAndProbesAlong) {
  Rod rod(4);
  rod.problem.loads = {rod.pad(1e4, 1e-3)};
  rod.hold_left();
  rod.problem.duration_s = 0.05;
  const MotionHistory coarse = move("moving_fem.p2", rod.mesh, rod.problem);
  const MotionHistory fine = move("moving_fem.p2", rod.mesh, rod.problem, {{"refine", 1}});
  EXPECT_GT(report_.at("dofs").get<int>(), 3000);
  const double far = column(fine, "probe_1_ux_m").back();
  EXPECT_NEAR(column(coarse, "probe_1_ux_m").back(), far, 0.02 * std::fabs(far));
}

// A pad, a clamp that lets go and damping: every figure of the history, and the frequencies, to what the
// solver leaves of the greatest.
TEST_F(MovingElements, TwoProcessesMoveAlike) {
  Rod rod(4);
  rod.problem.loads = {rod.pad(rod.modulus_pa() / Rod::kLengthM, 1e-3)};
  rod.hold_left();
  rod.problem.duration_s = 0.05;
  rod.problem.damping_stiffness_s = 1e-3;
  rod.problem.damping_mass_per_s = 2.0;
  rod.problem.frequencies = 3;
  for (const auto& [method, solver] : {std::pair{"moving_fem.p1", "mumps"}, {"moving_fem.p2", "cg"}}) {
    std::vector<MotionHistory> histories;
    std::vector<json> reports;
    for (const int processes : {1, 2}) {
      histories.push_back(
          move(method, rod.mesh, rod.problem,
               {{"processes", processes}, {"solver", solver}, {"time_step_s", 1e-3}, {"rtol", 1e-11}}));
      reports.push_back(report_);
      EXPECT_EQ(report_.at("processes"), processes);
    }
    ASSERT_EQ(histories[0].columns, histories[1].columns);
    for (const std::string& name : histories[0].columns) {
      const std::vector<double> one = column(histories[0], name);
      const std::vector<double> two = column(histories[1], name);
      ASSERT_EQ(one.size(), two.size());
      double most = 0.0;
      for (const char* axis : {"x", "y", "z"}) {  // a vector's parts are held to its greatest
        std::string beside = name;
        const std::size_t at = beside.rfind("x_") != std::string::npos   ? beside.rfind("x_")
                               : beside.rfind("y_") != std::string::npos ? beside.rfind("y_")
                                                                         : beside.rfind("z_");
        if (at != std::string::npos) beside.replace(at, 1, axis);
        for (const double value : column(histories[0], beside)) most = std::max(most, std::fabs(value));
      }
      for (std::size_t k = 0; k < one.size(); ++k) EXPECT_NEAR(two[k], one[k], 1e-7 * most) << method << name;
    }
    for (std::size_t k = 0; k < 3; ++k) {
      const double hz = reports[0].at("frequencies_hz").at(k).get<double>();
      EXPECT_NEAR(reports[1].at("frequencies_hz").at(k).get<double>(), hz, 1e-7 * hz);
    }
  }
}

TEST_F(MovingElements, WhatCannotBeIsRefused) {
  Rod rod(2);
  rod.hold_left();
  const auto refused = [&](const MotionProblem& problem, const json& options, const std::string& reason) {
    const ContestantAnswer answer = run("moving_fem.p2", rod.mesh, problem, options);
    EXPECT_EQ(answer.outcome, "bad_input") << reason;
    EXPECT_THAT(answer.message, HasSubstr(reason));
  };
  refused(rod.problem, {{"time_step_s", 0.0}}, "time_step_s");
  refused(rod.problem, {{"time_step_s", -1e-3}}, "time_step_s");
  refused(rod.problem, {{"time_step_s", 1e-9}, {"solver", "jacobi"}}, "solver");
  refused(rod.problem, {{"time_step_s", 1e-9}}, "at most 1e8 steps");
  refused(rod.problem, {{"step", 1e-3}}, "step");
  MotionProblem problem = rod.problem;
  problem.frequencies = 1000;
  refused(problem, json::object(), "no more than the body has");
  problem = rod.problem;
  problem.body.strain = StrainSize::kLarge;
  refused(problem, json::object(), "small");
  problem = rod.problem;
  MotionLoad hand = rod.empty_load();
  hand.part.held.push_back({rod.left(), {true, false, false}, {1e-3, 0.0, 0.0}});
  problem.loads = {hand};
  refused(problem, json::object(), "held by one load at a time");
}

}  // namespace
}  // namespace palpate::experiments

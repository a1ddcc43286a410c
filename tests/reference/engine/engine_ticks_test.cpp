// engine.ticks as the runner starts it: the force of a pad on a rod in closed form, whatever steps the rod.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "reference/door/json_file.h"
#include "reference/door/moving_body.h"
#include "tests/support/contestant_starter.h"
#include "tests/support/rod.h"

namespace palpate::reference {
namespace {

using dynamics::IntegratorKind;
using experiments::ContestantAnswer;
using nlohmann::json;
using testing::HasSubstr;

/// Linear elements, no smoothing at all.
const json kLinearElements{{"theta", 0.0}, {"rest", "tet"}, {"domain", "tet"}};

class EngineTicks : public testing::Test {
 protected:
  EngineTicks() {
    body_.motion = rod_.problem;
    body_.model.method = "smoothed.blend";
    body_.model.options = kLinearElements;
    body_.stepping.solver = {200, 1e-9};
  }

  void make_large() {
    body_.motion.body.strain = StrainSize::kLarge;
    body_.motion.loads[0].part.strain = StrainSize::kLarge;
  }

  ContestantAnswer ask(const json& options, const std::string& method = "engine.ticks") {
    return starter_.run(method, rod_.mesh, moving_body_to_json(body_), options);
  }

  /// The pad's force along x at each of 1100 ticks of 1 ms, of which 1000 are timed; the rod is at rest in
  /// the last ones.
  std::vector<double> forces_of(json options, const std::string& method = "engine.ticks") {
    options["ticks"] = 1000;
    const ContestantAnswer answer = ask(options, method);
    EXPECT_EQ(answer.outcome, "ok") << answer.message;
    if (answer.outcome != "ok") return std::vector<double>(1100, 0.0);
    report_ = answer.report;
    notes_ = answer.notes;
    EXPECT_EQ(report_.at("outcome"), "completed");
    EXPECT_GT(report_.at("setup_s").get<double>(), 0.0);
    EXPECT_GT(report_.at("first_tick_s").get<double>(), 0.0);
    const json file = read_json_file(answer.output);
    std::vector<double> out;
    for (const json& row : file.at("rows")) out.push_back(row[1].get<double>());
    return out;
  }

  static double difference(const std::vector<double>& a, const std::vector<double>& b) {
    EXPECT_EQ(a.size(), b.size());
    double most = 0.0;
    for (std::size_t k = 0; k < std::min(a.size(), b.size()); ++k)
      most = std::max(most, std::fabs(a[k] - b[k]));
    return most;
  }

  test::ContestantStarter starter_;
  test::PushedRod rod_;
  MovingBody body_;
  json report_;
  std::vector<std::string> notes_;
};

TEST_F(EngineTicks, EveryIntegratorEndsAtTheStaticReaction) {
  const double expected = rod_.pad_force_n();
  for (const IntegratorKind kind : dynamics::kIntegrators) {
    // Explicit Euler's step is too short here; XPBD has no small strain (below).
    if (kind == IntegratorKind::kExplicitEuler || kind == IntegratorKind::kXpbd) continue;
    body_.stepping.integrator = kind;
    body_.stepping.time_step_s.reset();
    if (dynamics::is_implicit(kind)) body_.stepping.time_step_s = 1e-3;
    const char* name = dynamics::integrator_name(kind);
    const std::vector<double> force = forces_of({{"precision", "double"}});
    EXPECT_NEAR(force.back(), expected, 1e-6 * std::fabs(expected)) << name;
    EXPECT_EQ(report_.at("integrator"), name);
    EXPECT_EQ(report_.at("engine"), kind == IntegratorKind::kSymplecticEuler ? "tets" : "general") << name;
    EXPECT_EQ(report_.contains("steps_unsolved"), dynamics::is_implicit(kind)) << name;
    if (dynamics::is_implicit(kind)) {
      EXPECT_EQ(report_.at("steps_per_tick"), 1) << name;
      EXPECT_EQ(report_.at("steps_unsolved"), 0) << name;
    }
  }
}

TEST_F(EngineTicks, ModesWithTheirCorrectionEndThereToo) {
  const double expected = rod_.pad_force_n();
  for (const char* elements : {"p1", "p2"}) {
    const std::vector<double> force =
        forces_of({{"modes", 3}, {"elements", elements}}, "reduced.modal_ticks");
    EXPECT_NEAR(force.back(), expected, 1e-6 * std::fabs(expected)) << elements;
  }
  // On the way it is the motion of linear elements, as far as consistent masses and few modes let it be.
  body_.stepping.integrator = IntegratorKind::kTrapezoidal;
  body_.stepping.time_step_s = 1e-3;
  const std::vector<double> stepped = forces_of({{"precision", "double"}});
  const std::vector<double> modal = forces_of({{"modes", 6}, {"elements", "p1"}}, "reduced.modal_ticks");
  EXPECT_LT(difference(stepped, modal), 0.05 * std::fabs(expected));
  // What modes alone leave of a pad's force is no force at all: the correction is what the test is of.
  const std::vector<double> bare =
      forces_of({{"modes", 1}, {"elements", "p1"}, {"correction", false}}, "reduced.modal_ticks");
  EXPECT_GT(std::fabs(bare.back() - expected), 0.05 * std::fabs(expected));
}

TEST_F(EngineTicks, SweepsAndIterationsComeToBackwardEulersForces) {
  make_large();
  body_.model.options = {{"domain", "tet"}, {"theta", 1.0}, {"law", "stable_neo_hookean"}};
  body_.stepping.time_step_s = 1e-3;
  body_.stepping.integrator = IntegratorKind::kBackwardEuler;
  const std::vector<double> solved = forces_of({{"precision", "double"}});
  const double size = std::fabs(solved.back());
  EXPECT_NEAR(solved.back(), rod_.pad_force_n(), 0.02 * size);  // strains below a percent
  for (const IntegratorKind kind : {IntegratorKind::kXpbd, IntegratorKind::kVbd}) {
    const char* name = dynamics::integrator_name(kind);
    body_.stepping.integrator = kind;
    body_.stepping.solver = {20000, 1e-7};
    EXPECT_LT(difference(solved, forces_of({{"precision", "double"}})), 1e-3 * size) << name;
    // One sweep a step is another motion, and the report says that it left something.
    body_.stepping.solver = {1, 0.0};
    EXPECT_GT(difference(solved, forces_of({{"precision", "double"}})), 1e-3 * size) << name;
    EXPECT_GT(report_.at("residual_worst").get<double>(), 1e-3) << name;
  }
}

TEST_F(EngineTicks, AStepThatIsLongerThanATickIsCutToIt) {
  body_.stepping.integrator = IntegratorKind::kTrapezoidal;
  body_.stepping.time_step_s = 2e-3;
  forces_of({{"precision", "double"}});
  EXPECT_EQ(report_.at("time_step_s"), 1e-3);
  EXPECT_THAT(notes_, testing::Contains(HasSubstr("in place of the scene's 0.002 s")));
  body_.stepping.time_step_s = 4e-4;
  forces_of({{"precision", "double"}});
  EXPECT_EQ(report_.at("steps_per_tick"), 3);
}

TEST_F(EngineTicks, WhatCannotBeIsRefusedAndWhatIsNotSolvedIsSaid) {
  const auto refused = [&](const json& options, const std::string& reason) {
    const ContestantAnswer answer = ask(options);
    EXPECT_EQ(answer.outcome, "bad_input") << reason;
    EXPECT_THAT(answer.message, HasSubstr(reason));
  };
  body_.stepping.integrator = IntegratorKind::kBackwardEuler;
  refused({{"precision", "double"}}, "no bound to take a step from");
  body_.stepping.time_step_s = 1e-3;
  refused({{"precision", "single"}}, "single is for the plain engine and the tet engine");
  refused({}, "single is for the plain engine and the tet engine");
  body_.stepping.engine = EngineChoice::kTets;
  refused({{"precision", "double"}}, "the tet engine takes strain energies");
  body_.stepping.engine = EngineChoice::kAuto;
  body_.stepping.integrator = IntegratorKind::kPrefactored;
  body_.stepping.solver = {1, 1e-9};
  const ContestantAnswer answer = ask({{"precision", "double"}, {"ticks", 100}});
  ASSERT_EQ(answer.outcome, "ok") << answer.message;
  EXPECT_EQ(answer.report.at("outcome"), "unsolved");
  EXPECT_GT(answer.report.at("steps_unsolved"), 0);
  body_.motion.loads[0].until_s = 0.5;
  refused({{"precision", "double"}}, "comes or goes");
}

}  // namespace
}  // namespace palpate::reference

// Steps through the phases of a motion, damping by shares, and what phases add up to, counted by hand.
#include "reference/elastic_models/stepped_motion.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "core/base/error.h"

namespace palpate::reference {
namespace {

using dynamics::MotionOutcome;
using dynamics::MotionReport;
using testing::ElementsAre;
using testing::HasSubstr;

/// The message with which `call` refuses.
template <typename Call>
std::string refusal_of(const Call& call) {
  try {
    call();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

/// A load that is there for the first third of 0.3 s.
MotionProblem make_two_phases() {
  MotionProblem problem;
  problem.duration_s = 0.3;
  problem.samples = 5;
  problem.loads.emplace_back().until_s = 0.1;
  return problem;
}

TEST(SteppedMotion, FillsEachPhaseWithTheFewestSteps) {
  const StepPlan plan = plan_steps(make_two_phases(), 0.03, 1e9);
  ASSERT_EQ(plan.phases.size(), 2U);
  EXPECT_EQ(plan.phases[0].steps, 4U);
  EXPECT_DOUBLE_EQ(plan.phases[0].step_s, 0.025);
  EXPECT_EQ(plan.phases[1].steps, 7U);
  EXPECT_DOUBLE_EQ(plan.phases[1].step_s, 0.2 / 7.0);
  EXPECT_EQ(plan.stride, 3U);  // 11 steps, at most 5 rows after the first
  // Rounding makes no step more of one that fills a phase.
  const StepPlan whole = plan_steps(make_two_phases(), 0.1, 1e9);
  EXPECT_EQ(whole.phases[0].steps, 1U);
  EXPECT_EQ(whole.phases[1].steps, 2U);
  EXPECT_EQ(whole.stride, 1U);
  EXPECT_THAT(refusal_of([] { plan_steps(make_two_phases(), 1e-10, 1e9); }), HasSubstr("at most 1e9 steps"));
  EXPECT_THAT(refusal_of([] { plan_steps(make_two_phases(), 1e-9, 1e8); }), HasSubstr("at most 1e8 steps"));
}

TEST(SteppedMotion, TakesTheStepOrAShareOfTheBound) {
  const double none = std::numeric_limits<double>::infinity();
  EXPECT_EQ(choose_time_step({0.0, 0.5}, "euler", 0.2), 0.1);
  EXPECT_EQ(choose_time_step({0.2, 0.5}, "euler", 0.2), 0.2);
  EXPECT_EQ(choose_time_step({0.2, 0.5}, "euler", none), 0.2);
  EXPECT_THAT(refusal_of([] {
                choose_time_step({0.3, 0.5}, "euler", 0.2);
              }),
              HasSubstr("stable step of euler"));
  EXPECT_THAT(refusal_of([&] { choose_time_step({0.0, 0.5}, "euler", none); }), HasSubstr("has no bound"));
  EXPECT_THAT(refusal_of([] { choose_time_step({0.0, 0.5}, "euler", 0.0); }), HasSubstr("found none"));
}

TEST(SteppedMotion, DampsBySharesAndConstants) {
  dynamics::MotionModel model;
  model.elastic.springs = {{{0, 1}, {1, 2}}, {1.0, 1.0}, {10.0, 20.0}};
  model.mass_kg = {1.0, 2.0, 4.0};
  set_damping({0.5, 2.0, 1.0, 3.0}, model);
  EXPECT_EQ(model.strain_damping_s, 0.5);
  EXPECT_THAT(model.spring_damping_n_s_per_m, ElementsAre(6.0, 11.0));
  EXPECT_THAT(model.environment_damping_n_s_per_m, ElementsAre(5.0, 7.0, 11.0));
  set_damping({}, model);
  EXPECT_EQ(model.strain_damping_s, 0.0);
  EXPECT_TRUE(model.spring_damping_n_s_per_m.empty());
  EXPECT_TRUE(model.environment_damping_n_s_per_m.empty());
}

TEST(SteppedMotion, PhasesAddUp) {
  MotionReport first;
  first.steps = 10;
  first.steps_unsolved = 1;
  first.residual_worst = 0.5;
  first.inverted_tets = first.inverted_tets_most = 3;
  first.first_inversion_s = 0.25;
  first.outcome = MotionOutcome::kInverted;
  MotionReport second;
  second.steps = 5;
  second.residual_worst = 0.1;
  MotionReport all;
  add_phase(first, all);
  EXPECT_EQ(all.outcome, MotionOutcome::kInverted);
  add_phase(second, all);
  EXPECT_EQ(all.outcome, MotionOutcome::kUnsolved);  // no tet is inverted any more, but a step was not solved
  EXPECT_EQ(all.steps, 15U);
  EXPECT_EQ(all.residual_worst, 0.5);
  EXPECT_EQ(all.inverted_tets, 0U);
  EXPECT_EQ(all.inverted_tets_most, 3U);
  EXPECT_EQ(all.first_inversion_s, 0.25);
  second.outcome = MotionOutcome::kDiverged;
  add_phase(second, all);
  EXPECT_EQ(all.outcome, MotionOutcome::kDiverged);
}

}  // namespace
}  // namespace palpate::reference

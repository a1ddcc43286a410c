// Which integrator at which step: decided from motions that are made up.
#include "experiments/trials/fit_stepping.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <vector>

namespace palpate::experiments {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr double kFree = std::numeric_limits<double>::infinity();

FitStepping stepping_of(const std::string& label) {
  return {label, "trapezoidal", false, nullptr};
}

/// An integrator of order 2 whose steps take a millisecond each: error (h / 1 s)^2.
SteppedMotion of_order_two(double step_s) {
  return {1e-3 / step_s, step_s * step_s, ""};
}

TEST(FindStep, TheLongestThatLeavesLittleEnoughIsTaken) {
  std::vector<double> looked_at;
  const SteppingTry found = find_step(stepping_of("a"), 1.0, 0.01, 0.02, kFree, [&](double step_s) {
    looked_at.push_back(step_s);
    return of_order_two(step_s);
  });
  EXPECT_EQ(found.why_not, "");
  EXPECT_EQ(found.step_s, 0.125);  // 1/64 < 0.02 < 1/16
  EXPECT_EQ(found.error, 0.015625);
  EXPECT_EQ(found.cost(), 0.008);
  EXPECT_THAT(looked_at, ElementsAre(1.0, 0.5, 0.25, 0.125));
}

TEST(FindStep, OnTimesAloneItIsGivenUp) {
  // At 0.25 a second takes 4 ms and 6% are left: shorter steps are dearer still, whatever they leave.
  const SteppingTry dear = find_step(stepping_of("a"), 1.0, 0.01, 0.02, 3e-3, of_order_two);
  EXPECT_EQ(dear.step_s, 0.25);
  EXPECT_THAT(dear.why_not, AllOf(HasSubstr("leaves 6.25% of the motion"), HasSubstr("over 3 ms")));
  // One that holds is taken, however dear it is: what is cheapest is decided among those that hold.
  const SteppingTry held = find_step(stepping_of("a"), 0.125, 0.01, 0.02, 1e-9, of_order_two);
  EXPECT_EQ(held.why_not, "");
}

TEST(FindStep, WhereNoStepHoldsTheShortestIsNamed) {
  const SteppingTry none = find_step(stepping_of("a"), 1.0, 0.25, 1e-6, kFree, of_order_two);
  EXPECT_EQ(none.step_s, 0.25);
  EXPECT_THAT(none.why_not, HasSubstr("at a step of 250 ms"));
  const SteppingTry bad = find_step(stepping_of("a"), 1.0, 0.25, 0.1, kFree, [](double) {
    return SteppedMotion{kFree, std::nullopt, "diverged"};
  });
  EXPECT_EQ(bad.step_s, 1.0) << "what takes forever is not made shorter";
  EXPECT_THAT(bad.why_not, HasSubstr("diverged"));
  const SteppingTry short_one = find_step(stepping_of("a"), 0.1, 0.25, 0.1, kFree, of_order_two);
  EXPECT_THAT(short_one.why_not, HasSubstr("is shorter than the shortest"));
  EXPECT_TRUE(short_one.cost_s.empty());
}

/// A NaN is no error that could hold.
TEST(FindStep, ANumberThatIsNoneHoldsNothing) {
  const SteppingTry found = find_step(stepping_of("a"), 1.0, 0.5, 0.1, kFree, [](double) {
    return SteppedMotion{1.0, std::numeric_limits<double>::quiet_NaN(), ""};
  });
  EXPECT_NE(found.why_not, "");
}

/// A body ten times as stiff in its waves: explicit steps get ten times as many, those of the other
/// integrator stay as they are. By the same counts of work the soft body is cheaper by explicit steps, the
/// stiff one by the implicit ones.
TEST(ChooseStepping, StiffBodiesAreSteppedImplicitlyByTheCountOfWork) {
  constexpr double kExplicitWork = 1.0;   // a product with the stiffness
  constexpr double kImplicitWork = 40.0;  // a back-substitution
  for (const double bound_s : {1e-3, 1e-5}) {
    const SteppingTry steps = find_step({"explicit", kExplicitIntegrator, false, nullptr}, bound_s, bound_s,
                                        0.01, kFree, [&](double step_s) {
                                          return SteppedMotion{kExplicitWork / step_s, step_s, ""};
                                        });
    const SteppingTry other =
        find_step(stepping_of("trapezoidal"), 0.05, 2.0 * bound_s, 0.01, steps.cost(), [&](double step_s) {
          return SteppedMotion{kImplicitWork / step_s, 15.0 * step_s * step_s, ""};
        });
    const std::vector<SteppingTry> tries{steps, other};
    ASSERT_NE(choose_stepping(tries), nullptr);
    EXPECT_EQ(choose_stepping(tries)->stepping.label, bound_s == 1e-3 ? "explicit" : "trapezoidal");
  }
}

TEST(ChooseStepping, WhatIsNotVerifiedIsNeverTaken) {
  SteppingTry cheap{stepping_of("cheap"), 0.1, false, 0.5, {1.0}, "leaves 50%"};
  SteppingTry dear{stepping_of("dear"), 0.1, false, 0.01, {3.0, 9.0, 4.0}, ""};
  const std::vector<SteppingTry> both{cheap, dear};
  EXPECT_EQ(choose_stepping(both), &both[1]);
  EXPECT_EQ(dear.cost(), 4.0);
  EXPECT_EQ(choose_stepping(std::vector<SteppingTry>{cheap}), nullptr);
  EXPECT_EQ(choose_stepping({}), nullptr);
}

TEST(FitSteppings, MemoryIsHeldAgainstWhatThereMayBe) {
  EXPECT_EQ(over_memory(501, 500), "takes 501 bytes, over 500");
  EXPECT_EQ(over_memory(500, 500), "");
  EXPECT_EQ(over_memory(501, std::nullopt), "");
  EXPECT_EQ(over_memory(0, 500), "") << "not measured";
  const SteppingTry found = find_step(stepping_of("a"), 1.0, 0.01, 0.02, kFree, [](double step_s) {
    SteppedMotion motion = of_order_two(step_s);
    motion.memory_bytes = step_s == 0.5 ? 900 : 700;
    return motion;
  });
  EXPECT_EQ(found.memory_bytes, 900U) << "the most of all its runs";
}

TEST(FitSteppings, ReplaceWhatTheSceneHad) {
  json scene = json::parse(R"({"analysis": {"dynamic": {"integrator": "runge_kutta_4", "time_step_s": "auto",
    "safety": 0.5, "engine": "general", "duration_s": 2, "damping": {"mass_per_s": 3}}}})");
  FitStepping{"single", kExplicitIntegrator, true, nullptr}.apply(1e-4, scene);
  EXPECT_EQ(scene, json::parse(R"({"analysis": {"dynamic": {"integrator": "symplectic_euler",
    "time_step_s": 1e-4, "precision": "single", "duration_s": 2, "damping": {"mass_per_s": 3}}}})"));
  FitStepping{"solved", "prefactored", false, {{"iterations", 5}}}.apply(1e-3, scene);
  EXPECT_EQ(scene, json::parse(R"({"analysis": {"dynamic": {"integrator": "prefactored",
    "time_step_s": 1e-3, "solver": {"iterations": 5}, "duration_s": 2, "damping": {"mass_per_s": 3}}}})"));
}

}  // namespace
}  // namespace palpate::experiments

#include "core/dynamics/time_loop/motion_outcome.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "core/base/error.h"
#include "core/mesh/shapes/shapes.h"
#include "tests/support/dynamics_cases.h"
#include "tests/support/motion_cases.h"

namespace palpate::dynamics {
namespace {

using namespace testing_support;
using ::testing::HasSubstr;

/// An oscillator with omega = 1 that is let go at 1 mm.
WatchedRun watch_oscillator(IntegratorKind kind, double damping, double step, std::uint64_t steps) {
  MotionModel model = make_oscillator(1.0, damping);
  model.elastic.springs_are_linear = true;
  IntegratorOptions options;
  options.kind = kind;
  MotionState start = start_at_rest(model);
  start.displacement_m[1].x = 1e-3;
  WatchOptions watch;
  watch.step_s = step;
  watch.steps = steps;
  WatchedRun run = watch_motion(*make_stepper(model, options), start, watch);
  EXPECT_EQ(run.inverted_start, 0U);
  return run;
}

TEST(MotionOutcome, ADampedOscillatorComesToRest) {
  const WatchedRun run = watch_oscillator(IntegratorKind::kSymplecticEuler, 1.0, 0.01, 4000);
  EXPECT_EQ(run.outcome, WatchedOutcome::kSteady);
  EXPECT_EQ(run.steps, 4000U);
  EXPECT_EQ(run.vertex, kNoIndex);
  EXPECT_DOUBLE_EQ(run.time_s, 40.0);
  EXPECT_LT(run.drift_m, 1e-10);
  EXPECT_NEAR(run.energy_start_j, 1e-6, 1e-12);  // 1/2 m omega^2 x^2
  EXPECT_EQ(run.energy_most_j, run.energy_start_j);
}

TEST(MotionOutcome, AnUndampedOneMovesOn) {
  const WatchedRun run = watch_oscillator(IntegratorKind::kVelocityVerlet, 0.0, 0.01, 4000);
  EXPECT_EQ(run.outcome, WatchedOutcome::kOscillating);
  EXPECT_NEAR(run.kinetic_end_j, 1e-6, 1e-9);
  EXPECT_FALSE(is_unstable(run.outcome));
}

TEST(MotionOutcome, ExplicitEulerWithoutDampingGrowsByItsFactor) {
  const WatchedRun run = watch_oscillator(IntegratorKind::kExplicitEuler, 0.0, 0.01, 4000);
  EXPECT_EQ(run.outcome, WatchedOutcome::kEnergyGrowing);
  // Energy grows by 1 + p a step, p = (h omega)^2.
  EXPECT_NEAR(run.energy_most_j / run.energy_start_j, std::pow(1.0001, 4000), 1e-3);
  EXPECT_EQ(run.vertex, 1U);
  EXPECT_DOUBLE_EQ(run.time_s, 40.0);
  EXPECT_TRUE(is_unstable(run.outcome));
}

TEST(MotionOutcome, OverTheBoundItDivergesAtTheStepThatTheoryNames) {
  const double h = 2.2;
  const WatchedRun run = watch_oscillator(IntegratorKind::kSymplecticEuler, 0.0, h, 4000);
  EXPECT_EQ(run.outcome, WatchedOutcome::kDiverged);
  EXPECT_EQ(run.vertex, 1U);
  // |z| of z^2 - (2 - p) z + 1: x grows from 1 mm to 1000 body lengths of 1 m.
  const double t = h * h - 2.0;
  const double z = 0.5 * (t + std::sqrt(t * t - 4.0));
  const double steps = std::log(1e6) / std::log(z);
  EXPECT_NEAR(static_cast<double>(run.steps), steps, 1.5);
  EXPECT_DOUBLE_EQ(run.time_s, static_cast<double>(run.steps) * h);
  EXPECT_TRUE(is_unstable(run.outcome));
}

TEST(MotionOutcome, AStepThatOverflowsIsNonFinite) {
  const WatchedRun run = watch_oscillator(IntegratorKind::kSymplecticEuler, 0.0, 1e200, 10);
  EXPECT_EQ(run.outcome, WatchedOutcome::kNonFinite);
  EXPECT_EQ(run.steps, 1U);
  EXPECT_EQ(run.vertex, 1U);
  EXPECT_TRUE(std::isfinite(run.drift_m) && std::isfinite(run.energy_most_j));
}

TEST(MotionOutcome, ABodyTurnedInsideOutStaysSo) {
  // Springs have no sense of orientation: the mirror image is a rest shape too.
  const TetMesh mesh = build_kuhn_cube(1, 0.0, 0);
  const MotionModel model = make_free_body(mesh, 0.0);
  MotionState start = start_at_rest(model);
  for (std::size_t v = 0; v < mesh.points.size(); ++v) start.displacement_m[v].x = -2.0 * mesh.points[v].x;
  WatchOptions watch;
  watch.step_s = 1e-4;
  watch.steps = 100;
  const WatchedRun run = watch_motion(*make_stepper(model, {}), start, watch);
  EXPECT_EQ(run.outcome, WatchedOutcome::kInverted);
  EXPECT_EQ(run.inverted_start, 6U);
  EXPECT_EQ(run.inverted_end, 6U);
  EXPECT_EQ(run.vertex, mesh.tets[0][0]);
  EXPECT_EQ(run.time_s, 0.0);
}

TEST(MotionOutcome, OneThatIsGivenUpIsTooSlow) {
  const MotionModel model = make_oscillator(1.0, 0.0);
  int asked = 0;
  WatchOptions watch;
  watch.step_s = 0.01;
  watch.steps = 4000;
  watch.give_up = [&] { return ++asked == 5; };
  const WatchedRun run = watch_motion(*make_stepper(model, {}), start_at_rest(model), watch);
  EXPECT_EQ(run.outcome, WatchedOutcome::kTooSlow);
  EXPECT_EQ(run.steps, 40U);  // the start, then every tenth step
}

TEST(MotionOutcome, ALongRunIsTakenInPiecesAndEndsAtTheSameStep) {
  MotionModel model = make_oscillator(1.0, 0.0);
  model.elastic.springs_are_linear = true;
  MotionState start = start_at_rest(model);
  start.displacement_m[1].x = 1e-300;
  WatchOptions watch;
  watch.step_s = 2.00001;
  WatchedRun first;
  for (const std::uint64_t steps : {200'000ULL, 5'000'000ULL}) {
    watch.steps = steps;
    const WatchedRun run = watch_motion(*make_stepper(model, {}), start, watch);
    EXPECT_EQ(run.outcome, WatchedOutcome::kDiverged);
    if (first.steps == 0) first = run;
    EXPECT_EQ(run.steps, first.steps);
  }
  EXPECT_GT(first.steps, 100'000U);
}

TEST(MotionOutcome, RestIsSteadyAndStaysWhereItIs) {
  const MotionModel model = make_free_body(build_kuhn_cube(1, 0.0, 0), 0.0);
  for (const Precision precision : {Precision::kDouble, Precision::kSingle}) {
    WatchOptions watch;
    watch.step_s = 1e-3;
    watch.steps = 2000;
    const auto stepper = make_plain_stepper(model, precision, 1);
    const WatchedRun run = watch_motion(*stepper, start_at_rest(model), watch);
    EXPECT_EQ(run.outcome, WatchedOutcome::kSteady) << precision_name(precision);
    EXPECT_LT(run.drift_m, precision == Precision::kDouble ? 1e-13 : 1e-5);
  }
}

TEST(MotionOutcome, GrowthThatARunIsTooShortForIsNamedWhereItIsKnown) {
  // Explicit Euler grows by (h omega)^2 = 1e-8 a step: 1000 steps show 1e-5 of it.
  MotionModel model = make_oscillator(1.0, 0.0);
  IntegratorOptions options;
  options.kind = IntegratorKind::kExplicitEuler;
  MotionState start = start_at_rest(model);
  start.displacement_m[1].x = 1e-3;
  WatchOptions watch;
  watch.step_s = 1e-4;
  watch.steps = 1000;
  EXPECT_FALSE(is_unstable(watch_motion(*make_stepper(model, options), start, watch).outcome));
  watch.is_known_to_grow = true;
  const WatchedRun named = watch_motion(*make_stepper(model, options), start, watch);
  EXPECT_EQ(named.outcome, WatchedOutcome::kGrowingSlowly);
  EXPECT_TRUE(is_unstable(named.outcome));
  watch.step_s = 0.5;  // what shows itself keeps its own name
  EXPECT_EQ(watch_motion(*make_stepper(model, options), start, watch).outcome, WatchedOutcome::kDiverged);
}

TEST(MotionOutcome, NamesAndBadInput) {
  EXPECT_STREQ(watched_outcome_name(WatchedOutcome::kGrowingSlowly), "growing_slowly");
  EXPECT_STREQ(watched_outcome_name(WatchedOutcome::kEnergyGrowing), "energy_growing");
  EXPECT_STREQ(watched_outcome_name(WatchedOutcome::kTooSlow), "too_slow");
  const MotionModel model = make_oscillator(1.0, 0.0);
  const auto stepper = make_stepper(model, {});
  const auto error_with = [&](auto&& change) -> std::string {
    WatchOptions watch;
    watch.step_s = 0.1;
    watch.steps = 10;
    change(watch);
    try {
      watch_motion(*stepper, start_at_rest(model), watch);
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  };
  for (const double bad : {0.0, -1.0, std::nan(""), std::numeric_limits<double>::infinity()})
    EXPECT_THAT(error_with([&](WatchOptions& w) { w.step_s = bad; }), HasSubstr("step: expected"));
  EXPECT_THAT(error_with([](WatchOptions& w) { w.steps = 0; }), HasSubstr("steps: expected at least one"));
  EXPECT_THAT(error_with([](WatchOptions& w) { w.samples = 2; }), HasSubstr("samples: expected at least 8"));
  EXPECT_THAT(error_with([](WatchOptions& w) { w.escape_ratio = std::nan(""); }), HasSubstr("escape ratio"));
  EXPECT_THAT(error_with([](WatchOptions& w) { w.energy_factor = -1.0; }), HasSubstr("energy factor"));
}

/// Stays where it was put, but that no step is solved, until it flies away.
class FlyingStepper : public BodyStepper {
 public:
  FlyingStepper(const MotionModel& model, std::uint64_t steps) : model_(model), steps_(steps) {}

  const MotionModel& model() const override { return model_; }
  void set_state(const MotionState& state) override {
    state_ = state;
    unsolved_ = 0;
  }
  void advance(double step_s, std::uint64_t steps) override {
    unsolved_ += steps;
    state_.time_s += step_s * static_cast<double>(steps);
    if (state_.time_s > step_s * (static_cast<double>(steps_) - 0.5)) state_.displacement_m[1].x = 1e9;
  }
  const MotionState& state() override { return state_; }
  std::uint64_t steps_unsolved() const override { return unsolved_; }
  double rounding() const override { return 1e-14; }

 private:
  const MotionModel& model_;
  std::uint64_t steps_;
  std::uint64_t unsolved_ = 0;
  MotionState state_;
};

/// The last piece of a long run is taken again, by a stepper that then counts from nothing.
TEST(MotionOutcome, StepsThatWereNotSolvedAreCountedOnWhereAPieceIsTakenAgain) {
  const MotionModel model = make_oscillator(1.0, 0.0);
  const std::uint64_t last = 250'001;
  FlyingStepper stepper(model, last);
  WatchOptions watch;
  watch.step_s = 0.5;
  watch.steps = 400'000;
  watch.keeps_rows = true;
  const WatchedRun run = watch_motion(stepper, start_at_rest(model), watch);
  EXPECT_EQ(run.outcome, WatchedOutcome::kDiverged);
  EXPECT_EQ(run.steps, last);
  EXPECT_EQ(run.steps_unsolved, last);
  ASSERT_GT(run.rows.size(), 10U);
  for (const WatchedRow& row : run.rows) EXPECT_EQ(row.unsolved, row.step);
}

}  // namespace
}  // namespace palpate::dynamics

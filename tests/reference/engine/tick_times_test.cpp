#include "reference/engine/tick_times.h"

#include <gtest/gtest.h>

#include <numeric>

#include "core/base/error.h"
#include "core/dynamics/spring_engine/plain_engine.h"
#include "core/dynamics/tet_engine/tet_engine.h"
#include "core/mesh/shapes/shapes.h"
#include "tests/support/dynamics_cases.h"
#include "tests/support/motion_cases.h"

namespace palpate::reference {
namespace {

using namespace testing_support;

TEST(TickTimes, PercentilesAreTimesThatOccurred) {
  std::vector<double> seconds(1000);
  std::iota(seconds.begin(), seconds.end(), 1.0);  // 1 to 1000
  std::reverse(seconds.begin(), seconds.end());
  const TickTimes times = describe_ticks(seconds, 990.0);
  EXPECT_EQ(times.p50_s, 500.0);
  EXPECT_EQ(times.p99_s, 990.0);
  EXPECT_EQ(times.p99_9_s, 999.0);
  EXPECT_EQ(times.worst_s, 1000.0);
  EXPECT_EQ(times.mean_s, 500.5);
  EXPECT_EQ(times.missed, 10U);  // at the deadline is in time
  EXPECT_EQ(std::accumulate(times.buckets.begin(), times.buckets.end(), std::uint64_t{0}), 1000U);
  ASSERT_EQ(times.buckets.size(), times.bucket_ends_s.size());
  EXPECT_EQ(times.buckets.size(), 61U);  // three decades of twenty, and the one that starts at 1000
  EXPECT_NEAR(times.bucket_ends_s[19], 10.0, 1e-12);
  EXPECT_EQ(std::accumulate(times.buckets.begin(), times.buckets.begin() + 20, std::uint64_t{0}), 9U);
}

TEST(TickTimes, OneTickIsAllOfItsPercentiles) {
  const TickTimes times = describe_ticks({2e-3}, 1e-3);
  for (const double time : {times.p50_s, times.p99_s, times.p99_9_s, times.worst_s, times.mean_s})
    EXPECT_EQ(time, 2e-3);
  EXPECT_EQ(times.missed, 1U);
}

dynamics::MotionModel pressed() {
  return make_pressed_body(build_kuhn_cube(3, 0.2, 5), 0.02);
}

/// Twenty ticks of four steps, five before them, the force of group 1.
TickOptions short_loop(EngineChoice engine) {
  TickOptions options;
  options.steps_per_tick = 4;
  options.loop.ticks = 20;
  options.loop.warm_ticks = 5;
  options.engine = engine;
  options.single_precision = false;
  options.tool = 1;
  return options;
}

template <typename Engine>
void expect_engine_ticks(const dynamics::MotionModel& model, EngineChoice kind) {
  TickOptions options = short_loop(kind);
  const TickRun run = run_ticks(model, options);
  EXPECT_FALSE(run.diverged);
  EXPECT_EQ(run.seconds.size(), 20U);
  for (const double s : run.seconds) EXPECT_GT(s, 0.0);
  EXPECT_GT(run.first_tick_s, 0.0);
  ASSERT_EQ(run.force_n.size(), 25U);
  Engine engine(model, {});
  for (const Vec3& force : run.force_n) {
    engine.step(1e-3 / 4.0, 4);
    EXPECT_EQ(force, engine.group_forces()[1]);
  }
  EXPECT_EQ(hash_state(run.state), hash_state(engine.state()));
  options.integrator.threads = 2;
  options.loop.paced = true;
  EXPECT_EQ(run_ticks(model, options).force_n, run.force_n);
}

TEST(TickTimes, ATickIsItsStepsAndTheForceOfTheTool) {
  expect_engine_ticks<dynamics::PlainEngine<double>>(pressed(), EngineChoice::kPlain);
}

TEST(TickTimes, TheTetEngineTicksAsThePlainOne) {
  const TetMesh mesh = build_kuhn_cube(3, 0.2, 5);
  for (const auto law : {dynamics::StrainLaw::kCorotated, dynamics::StrainLaw::kNeoHookean}) {
    expect_engine_ticks<dynamics::TetEngine<double>>(
        make_continuum(make_pressed_body(mesh, 0.02), mesh, Continuum::kTets, law), EngineChoice::kTets);
  }
}

TEST(TickTimes, TheGeneralEngineGivesTheForceAtTheEndOfATick) {
  const dynamics::MotionModel model = pressed();
  for (const dynamics::IntegratorKind kind : dynamics::kIntegrators) {
    if (kind == dynamics::IntegratorKind::kExplicitEuler) continue;
    TickOptions options = short_loop(EngineChoice::kGeneral);
    options.integrator.kind = kind;
    const TickRun run = run_ticks(model, options);
    const char* name = dynamics::integrator_name(kind);
    EXPECT_FALSE(run.diverged) << name;
    ASSERT_EQ(run.force_n.size(), 25U) << name;
    dynamics::Integrator own(model, options.integrator);
    dynamics::MotionState state = start_at_rest(model);
    std::uint64_t unsolved = 0;
    for (const Vec3& force : run.force_n) {
      for (int k = 0; k < 4; ++k) unsolved += own.step(state, 1e-3 / 4.0).solved ? 0 : 1;
      EXPECT_EQ(force, own.forces().group_forces(state)[1]) << name;
    }
    EXPECT_EQ(run.steps_unsolved, unsolved) << name;
    EXPECT_EQ(hash_state(run.state), hash_state(state)) << name;
    options.integrator.threads = 2;
    EXPECT_EQ(run_ticks(model, options).force_n, run.force_n) << name;
  }
}

TEST(TickTimes, ABodyThatFliesApartEndsTheRun) {
  TickOptions options;
  options.loop.tick_s = 10.0;
  options.loop.ticks = 500;
  options.loop.warm_ticks = 0;
  options.tool = 1;
  for (const EngineChoice engine : {EngineChoice::kPlain, EngineChoice::kGeneral}) {
    options.engine = engine;
    options.single_precision = engine == EngineChoice::kPlain;
    const TickRun run = run_ticks(pressed(), options);
    EXPECT_TRUE(run.diverged);
    EXPECT_LT(run.seconds.size(), 500U);
    EXPECT_EQ(run.force_n.size(), run.seconds.size());
  }
}

TEST(TickTimes, SinglePrecisionOnTheGeneralEngineIsAFault) {
  TickOptions options = short_loop(EngineChoice::kGeneral);
  options.single_precision = true;
  EXPECT_THROW(run_ticks(pressed(), options), ContractError);
  options.engine = EngineChoice::kAuto;
  EXPECT_THROW(run_ticks(pressed(), options), ContractError);
}

}  // namespace
}  // namespace palpate::reference

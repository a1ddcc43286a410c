#include "core/dynamics/spring_engine/plain_engine.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <numeric>
#include <set>
#include <system_error>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/dynamics/integrators/integrator.h"
#include "core/dynamics/spring_engine/block_team.h"
#include "core/dynamics/stability/stability.h"
#include "core/dynamics/time_loop/plain_run.h"
#include "core/mesh/shapes/shapes.h"
#include "experiments/processes/child/sanitizers.h"
#include "tests/support/dynamics_cases.h"
#include "tests/support/engine_comparison.h"
#include "tests/support/motion_cases.h"

namespace palpate::dynamics {
namespace {

using namespace testing_support;

/// A cube of 2744 vertices, two blocks, held below, heavy, damped and shaken.
struct Shaken {
  MotionModel model;
  MotionState start;
};

Shaken make_shaken(SpringDamping damping = SpringDamping::kAxial) {
  const TetMesh mesh = build_kuhn_cube(13, 0.2, 5);
  Shaken out{make_pressed_body(mesh, 1.0), {}};
  out.model.loads.pop_back();
  out.model.spring_damping = damping;
  out.start = start_at_rest(out.model);
  out.start.velocity_m_s = make_random_field(mesh.points.size(), 0.1, 3);
  MotionForces forces(out.model, 1);
  forces.impose(0.0, out.start.displacement_m, out.start.velocity_m_s);
  return out;
}

template <typename Real>
MotionState run_plain(const Shaken& body, const PlainOptions& options, double step, std::uint64_t steps,
                      PlainReport* report = nullptr) {
  PlainEngine<Real> engine(body.model, options);
  engine.set_state(body.start);
  const PlainReport here = engine.step(step, steps);
  if (report != nullptr) *report = here;
  return engine.state();
}

TEST(PlainEngine, IsSymplecticEulerOfTheSameSprings) {
  const Shaken body = make_shaken();
  const double step = 1e-3;
  const MotionState expected = march(body.model, {}, body.start, 0.2, 200);
  const MotionState with_double = run_plain<double>(body, {}, step, 200);
  const MotionState with_float = run_plain<float>(body, {}, step, 200);
  const double size = field_norm(expected.displacement_m);
  // Rounding of positions of size 1, a few hundred times, against displacements of some hundredths.
  EXPECT_LT(field_distance(with_double.displacement_m, expected.displacement_m), 1e-12 * size);
  EXPECT_LT(field_distance(with_float.displacement_m, expected.displacement_m), 1e-3 * size);
  EXPECT_LT(field_distance(with_double.velocity_m_s, expected.velocity_m_s),
            1e-12 * field_norm(expected.velocity_m_s));
  EXPECT_NEAR(with_double.time_s, expected.time_s, 1e-12);
}

TEST(PlainEngine, OneThreadAndTwoGiveTheSameBits) {
  const Shaken body = make_shaken();
  EXPECT_EQ(hash_state(run_plain<float>(body, {1}, 1e-3, 20)),
            hash_state(run_plain<float>(body, {2}, 1e-3, 20)));
  EXPECT_EQ(hash_state(run_plain<double>(body, {1}, 1e-3, 20)),
            hash_state(run_plain<double>(body, {3}, 1e-3, 20)));
  EXPECT_NE(hash_state(run_plain<double>(body, {1}, 1e-3, 20)),
            hash_state(run_plain<double>(body, {1}, 1e-3, 21)));
}

TEST(PlainEngine, TheSpeedLimitIsThatOfTheIntegrator) {
  const Shaken body = make_shaken();
  IntegratorOptions slow;
  slow.speed_limit_m_s = 0.05;
  Integrator integrator(body.model, slow);
  MotionState expected = body.start;
  std::uint64_t cut = 0;
  for (int k = 0; k < 20; ++k) cut += integrator.step(expected, 1e-3).speeds_cut;
  PlainReport report;
  const MotionState got = run_plain<double>(body, {2, 0.05}, 1e-3, 20, &report);
  EXPECT_GT(cut, 0U);
  EXPECT_EQ(report.speeds_cut, cut);
  EXPECT_LT(field_distance(got.velocity_m_s, expected.velocity_m_s),
            1e-12 * field_norm(expected.velocity_m_s));
}

TEST(PlainEngine, ASpringWithoutLengthIsNoticedAndGivesNoForce) {
  Shaken body{make_oscillator(3.0, 0.1), {}};
  body.start = start_at_rest(body.model);
  body.start.displacement_m[1].x = -1.0;
  PlainReport report;
  const MotionState end = run_plain<double>(body, {}, 1e-3, 5, &report);
  EXPECT_EQ(report.steps_with_zero_length, 5U);
  EXPECT_EQ(end.displacement_m[1].x, -1.0);
  body.start.displacement_m[1].x = -0.5;
  run_plain<double>(body, {}, 1e-3, 5, &report);
  EXPECT_EQ(report.steps_with_zero_length, 0U);
}

/// A cube in the hands of a tool; all blocks have some of it.
MotionModel make_palpated_body() {
  const TetMesh mesh = build_kuhn_cube(13, 0.2, 5);
  MotionModel model = make_pressed_body(mesh, 0.2);
  add_palpation(mesh, model);
  return model;
}

TEST(PlainLoads, SupportsPadsToolsAndProfilesAreThoseOfTheIntegrator) {
  const MotionModel model = make_palpated_body();
  compare_with_integrator<PlainEngine<double>>(model, {}, 200, 1e-11);
  compare_with_integrator<PlainEngine<double>>(model, {2, 0.3}, 200, 1e-11);
  // Positions of size 1 are rounded to 6e-8, forces to some millionths of the largest spring's.
  compare_with_integrator<PlainEngine<float>>(model, {}, 200, 1e-3);
  compare_with_integrator<PlainEngine<double>>(make_pressed_body(build_kuhn_cube(4, 0.2, 5), 0.2), {}, 200,
                                               1e-11);
}

TEST(PlainLoads, ForcesAreTheSameBitsOnAnyNumberOfThreads) {
  const MotionModel model = make_palpated_body();
  PlainEngine<float> one(model, {1});
  PlainEngine<float> three(model, {3});
  one.step(1e-3, 50);
  three.step(1e-3, 50);
  EXPECT_EQ(hash_state(one.state()), hash_state(three.state()));
  ASSERT_EQ(one.group_forces().size(), model.loads.size());
  EXPECT_EQ(one.group_forces(), three.group_forces());
  EXPECT_GT(length(one.group_forces().back()), 0.0);
}

TEST(PlainEngine, AWatchedRunReportsThePeakSpeedAndStopsWhereItEscapes) {
  Shaken body = make_shaken();
  PlainOptions watched;
  watched.escape_m = 100.0;
  PlainReport report;
  const MotionState end = run_plain<double>(body, watched, 1e-3, 1, &report);
  double fastest = 0.0;
  for (const Vec3& v : end.velocity_m_s) fastest = std::max(fastest, length(v));
  EXPECT_DOUBLE_EQ(report.peak_speed_m_s, fastest);
  EXPECT_FALSE(report.diverged);
  EXPECT_EQ(report.steps, 1U);
  for (const int threads : {1, 2}) {
    watched.threads = threads;
    const MotionState escaped = run_plain<double>(body, watched, 1.0, 500, &report);
    EXPECT_TRUE(report.diverged);
    EXPECT_LT(report.steps, 500U);
    EXPECT_DOUBLE_EQ(escaped.time_s, static_cast<double>(report.steps));
  }
}

/// The same run on both engines, from rest.
struct TwoRuns {
  MotionReport general;
  MotionReport plain;
  MotionState general_end;
  MotionState plain_end;
  std::vector<std::uint64_t> general_seen;
  std::vector<std::uint64_t> plain_seen;
};

TwoRuns run_both(const MotionModel& model, const MotionRunOptions& options, double speed_limit) {
  TwoRuns out;
  IntegratorOptions general;
  general.speed_limit_m_s = speed_limit;
  Integrator integrator(model, general);
  out.general_end = out.plain_end = start_at_rest(model);
  out.general = run_motion(integrator, out.general_end, options,
                           [&](std::uint64_t step, const MotionState&) { out.general_seen.push_back(step); });
  out.plain =
      run_plain_motion(model, out.plain_end, {options, 2, speed_limit, false},
                       [&](std::uint64_t step, const MotionState&) { out.plain_seen.push_back(step); });
  EXPECT_EQ(out.plain.outcome, out.general.outcome);
  EXPECT_EQ(out.plain.steps, out.general.steps);
  EXPECT_EQ(out.plain.is_finite, out.general.is_finite);
  EXPECT_EQ(out.plain.state_hash, hash_state(out.plain_end));
  EXPECT_EQ(out.plain_seen, out.general_seen);
  return out;
}

TEST(PlainRun, ReportsWhatTheGeneralLoopReports) {
  const MotionModel model = make_palpated_body();
  const TwoRuns same = run_both(model, {1e-3, 100, 1000.0, 30}, 0.2);
  EXPECT_EQ(same.plain_seen, (std::vector<std::uint64_t>{0, 30, 60, 90, 100}));
  EXPECT_GT(same.general.speeds_cut, 0U);
  EXPECT_EQ(same.plain.speeds_cut, same.general.speeds_cut);
  EXPECT_EQ(same.plain.steps_with_cuts, same.general.steps_with_cuts);
  EXPECT_NEAR(same.plain.peak_speed_m_s, same.general.peak_speed_m_s, 1e-9);
  EXPECT_EQ(same.plain.inverted_tets, same.general.inverted_tets);
  const TwoRuns wild = run_both(model, {0.5, 400, 1000.0, 1000}, 0.0);
  EXPECT_EQ(wild.plain.outcome, MotionOutcome::kDiverged);
  EXPECT_NE(wild.plain.first_bad_vertex, kNoIndex);
  MotionState state = start_at_rest(model);
  EXPECT_THROW(run_plain_motion(model, state, {{0.0, 1, 1000.0, 0}}), InputError);
}

TEST(PlainRun, BeingAskedWhetherToStopChangesNoBit) {
  const MotionModel model = make_palpated_body();
  std::vector<std::uint64_t> seen;
  const auto run = [&](const std::function<bool()>& should_stop, MotionState& state) {
    seen.clear();
    PlainRunOptions options{{1e-3, 100, 1000.0, 30, should_stop}, 2, 0.2, false};
    return run_plain_motion(model, state, options,
                            [&](std::uint64_t step, const MotionState&) { seen.push_back(step); });
  };
  MotionState unasked = start_at_rest(model);
  MotionState asked = unasked;
  const MotionReport first = run({}, unasked);
  const MotionReport second = run([] { return false; }, asked);
  EXPECT_EQ(seen, (std::vector<std::uint64_t>{0, 30, 60, 90, 100}));
  EXPECT_EQ(second.state_hash, first.state_hash);
  EXPECT_EQ(second.steps_with_cuts, first.steps_with_cuts);
  EXPECT_EQ(second.outcome, first.outcome);
  // Asked first before a single step, then before two, four and so on where these are quick.
  int questions = 0;
  MotionState stopped = start_at_rest(model);
  const MotionReport early = run([&] { return ++questions > 1; }, stopped);
  EXPECT_EQ(early.outcome, MotionOutcome::kStopped);
  EXPECT_EQ(early.steps, 1U);
  EXPECT_EQ(seen, (std::vector<std::uint64_t>{0, 1}));
  EXPECT_EQ(early.state_hash, hash_state(stopped));
  EXPECT_GT(stopped.time_s, 0.0);
}

TEST(PlainRun, RoundingOfPositionsAddsTheEnergyThatIsNamed) {
  // An undamped body in single precision that moves by some hundred last bits a step.
  const TetMesh mesh = build_kuhn_cube(3, 0.2, 5);
  const MotionModel model = make_free_body(mesh, 0.0);
  const double gain = rounding_gain_per_step(model);
  constexpr std::uint64_t kSteps = 100'000;
  MotionState start = start_at_rest(model);
  start.velocity_m_s = make_random_field(mesh.points.size(), 3e-5, 3);
  const double step = 0.25 * predict_stable_step(model, IntegratorKind::kSymplecticEuler).step_s;
  const auto gained = [&](bool single_precision) {
    MotionState end = start;
    run_plain_motion(model, end, {{step, kSteps}, 1, 0.0, single_precision});
    return measure_energy(model, end).total_j() - measure_energy(model, start).total_j();
  };
  const double expected = static_cast<double>(kSteps) * gain;
  const double had = measure_energy(model, start).total_j();
  // Steps that go with the motion and against it spread by 2 sqrt(had x gained / coordinates) around that.
  const double coordinates = 3.0 * static_cast<double>(mesh.points.size());
  const double spread = 2.0 * std::sqrt((had + expected) * expected / coordinates);
  EXPECT_NEAR(gained(true), expected, 3.0 * spread);
  EXPECT_GT(expected, 4.0 * spread);  // or the line above would take none for some
  EXPECT_LT(std::abs(gained(false)), spread);
}

TEST(PlainEngine, RefusesWhatItCannotDo) {
  EXPECT_THROW(PlainEngine<double>(make_shaken(SpringDamping::kIsotropic).model, {}), InputError);
  const TetMesh mesh = build_kuhn_cube(1, 0.0, 1);
  EXPECT_THROW(PlainEngine<float>(make_free_body(mesh, 0.0, VolumeModel::kNodeAverage), {}), InputError);
  EXPECT_THROW(PlainEngine<float>(make_free_body(mesh, 0.0, VolumeModel::kThesis), {}), InputError);
  MotionModel linear = make_free_body(mesh, 0.0);
  linear.elastic.springs_are_linear = true;
  EXPECT_THROW(PlainEngine<float>(linear, {}), InputError);
}

/// Those that were made would wait for the others for ever.
TEST(PlainEngine, ThreadsThatCannotAllBeMadeEndTheRun) {
  if (experiments::kIsSanitized) GTEST_SKIP() << "AddressSanitizer leaves no room for a bound";
  const auto step_with_little_memory = [] {
    TeamStep<double> step;
    step.phases = {[](std::size_t, std::size_t, PlainReport&) {}};
    step.swap = [] {};
    step.blocks = 64;
    PlainOptions options;
    options.threads = 64;
    const MotionModel model = make_oscillator(1.0, 0.0);
    const std::vector<Index> order{0, 1};
    PlainLoads loads(model, {order, order, 2, {}});
    double time_s = 0.0;
    std::uint64_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    rlimit bound{};
    bound.rlim_cur = bound.rlim_max = pages * 4096 + (std::uint64_t{40} << 20U);  // stacks of four or five
    ::setrlimit(RLIMIT_AS, &bound);
    ::alarm(20);
    try {
      step_in_team(options, step, 0.01, 10, loads, time_s, {});
    } catch (const std::system_error&) {
      std::_Exit(7);
    }
    std::_Exit(0);
  };
  EXPECT_EXIT(step_with_little_memory(), testing::ExitedWithCode(7), "");
}

}  // namespace
}  // namespace palpate::dynamics

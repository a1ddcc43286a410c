// Models, forces and runs of bodies in motion.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/base/error.h"
#include "core/dynamics/time_loop/motion_run.h"
#include "core/mesh/geometry.h"
#include "core/mesh/shapes/shapes.h"
#include "tests/support/dynamics_cases.h"
#include "tests/support/motion_cases.h"

namespace palpate::dynamics {
namespace {

using namespace testing_support;

constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();

TEST(TimeProfile, RunsStraightOrSmoothlyAndStaysAtItsEnds) {
  TimeProfile profile{{1.0, 3.0, 4.0}, {0.0, 2.0, -1.0}, false};
  EXPECT_EQ(value_at(profile, 0.0).share, 0.0);
  EXPECT_EQ(value_at(profile, 2.0).share, 1.0);
  EXPECT_EQ(value_at(profile, 2.0).rate_per_s, 1.0);
  EXPECT_EQ(value_at(profile, 3.5).rate_per_s, -3.0);
  EXPECT_EQ(value_at(profile, 9.0).share, -1.0);
  EXPECT_EQ(value_at(profile, 9.0).rate_per_s, 0.0);
  profile.smooth = true;
  EXPECT_EQ(value_at(profile, 2.0).share, 1.0);
  EXPECT_EQ(value_at(profile, 3.0).rate_per_s, 0.0);
  const double h = 1e-5;
  for (const double t : {1.3, 2.9, 3.6}) {
    const double slope = (value_at(profile, t + h).share - value_at(profile, t - h).share) / (2.0 * h);
    const double bend =
        (value_at(profile, t + h).rate_per_s - value_at(profile, t - h).rate_per_s) / (2.0 * h);
    EXPECT_NEAR(value_at(profile, t).rate_per_s, slope, 1e-7);
    EXPECT_NEAR(value_at(profile, t).acceleration_per_s2, bend, 1e-6);
  }
}

TEST(TimeProfile, RefusesTimesThatDoNotIncrease) {
  EXPECT_THROW(validate(TimeProfile{{0.0, 0.0}, {1.0, 2.0}, false}), InputError);
  EXPECT_THROW(validate(TimeProfile{{0.0, 1.0}, {1.0}, false}), InputError);
  EXPECT_THROW(validate(TimeProfile{{}, {}, false}), InputError);
  EXPECT_THROW(validate(TimeProfile{{0.0, kNotANumber}, {1.0, 2.0}, false}), InputError);
}

TEST(MotionModel, RefusesMassesAndDampingThatAreNone) {
  const MotionModel good = make_oscillator(1.0, 0.1);
  EXPECT_NO_THROW(validate(good));
  for (const double bad : {0.0, -1.0, kNotANumber, std::numeric_limits<double>::infinity()}) {
    MotionModel model = good;
    model.mass_kg[1] = bad;
    EXPECT_THROW(validate(model), InputError);
    EXPECT_THROW(build_lumped_masses(build_kuhn_cube(1, 0.0, 1), bad), InputError);
  }
  for (const double bad : {-1.0, kNotANumber}) {
    MotionModel model = good;
    model.spring_damping_n_s_per_m[0] = bad;
    EXPECT_THROW(validate(model), InputError);
    model = good;
    model.environment_damping_n_s_per_m = {0.0, bad};
    EXPECT_THROW(validate(model), InputError);
  }
  MotionModel twice = good;
  twice.loads.push_back(twice.loads.front());
  EXPECT_THROW(validate(twice), InputError);
}

TEST(MotionModel, LumpedMassesAddUpToTheBody) {
  const TetMesh mesh = build_kuhn_cube(3, 0.2, 5);
  double sum = 0.0;
  for (const double mass : build_lumped_masses(mesh, 1050.0)) sum += mass;
  EXPECT_NEAR(sum, 1050.0 * total_volume(mesh), 1e-9);
}

TEST(MotionForces, AtRestOfVelocityTheyAreTheElasticForces) {
  const TetMesh mesh = build_kuhn_cube(2, 0.2, 3);
  const std::vector<Vec3> u = make_random_field(mesh.points.size(), 0.05, 1);
  const std::vector<Vec3> still(u.size());
  for (const VolumeModel volume : {VolumeModel::kNone, VolumeModel::kThesis, VolumeModel::kTet,
                                   VolumeModel::kNodeAverage, VolumeModel::kNodeSmoothed}) {
    const MotionModel model = make_free_body(mesh, 0.1, volume);
    std::vector<Vec3> expected(u.size());
    add_elastic_forces(model.elastic, u, expected);
    std::vector<Vec3> force(u.size());
    EXPECT_EQ(MotionForces(model, 1).evaluate(u, still, 0.0, force), 0U);
    EXPECT_LT(field_distance(force, expected), 1e-13 * field_norm(expected)) << volume_model_name(volume);
  }
}

TEST(MotionForces, DampingIsMinusItsMatrixTimesVelocity) {
  const TetMesh mesh = build_kuhn_cube(2, 0.2, 3);
  const std::vector<Vec3> u = make_random_field(mesh.points.size(), 0.05, 1);
  const std::vector<Vec3> v = make_random_field(mesh.points.size(), 1.0, 2);
  for (const SpringDamping kind : {SpringDamping::kAxial, SpringDamping::kIsotropic}) {
    MotionModel model = make_free_body(mesh, 0.1, VolumeModel::kNodeSmoothed);
    model.spring_damping = kind;
    model.environment_damping_n_s_per_m = model.mass_kg;
    BlockMatrix matrix = build_motion_pattern(model);
    add_changing_damping(model, u, matrix);
    add_constant_damping(model, matrix);
    std::vector<Vec3> product(u.size());
    multiply(matrix, v, product);
    MotionForces forces(model, 1);
    std::vector<Vec3> moving(u.size());
    std::vector<Vec3> still(u.size());
    forces.evaluate(u, v, 0.0, moving);
    forces.evaluate(u, std::vector<Vec3>(u.size()), 0.0, still);
    for (std::size_t i = 0; i < u.size(); ++i) moving[i] = still[i] - moving[i];
    EXPECT_LT(field_distance(moving, product), 1e-12 * field_norm(product));
  }
}

TEST(MotionForces, WhatGroupsExertIsTheRateOfMomentum) {
  const TetMesh mesh = build_kuhn_cube(2, 0.2, 5);
  const MotionModel model = [&] {
    MotionModel out = make_pressed_body(mesh, 1.0);
    out.environment_damping_n_s_per_m.clear();
    return out;
  }();
  MotionState state = march(model, {}, start_at_rest(model), 0.3, 100);
  MotionForces forces(model, 1);
  std::vector<Vec3> force(mesh.points.size());
  forces.evaluate(state.displacement_m, state.velocity_m_s, state.time_s, force);
  Vec3 rate;
  for (std::size_t v = 0; v < force.size(); ++v) {
    const std::uint8_t bits = forces.held_bits()[v];
    rate = rate + Vec3{(bits & 1U) != 0 ? 0.0 : force[v].x, (bits & 2U) != 0 ? 0.0 : force[v].y,
                       (bits & 4U) != 0 ? 0.0 : force[v].z};
  }
  for (const HeldComponent& held : forces.held()) {
    const double push = model.mass_kg[held.vertex] * held.by_m *
                        value_at(model.loads[held.group].profile, state.time_s).acceleration_per_s2;
    (held.axis == 0 ? rate.x : (held.axis == 1 ? rate.y : rate.z)) += push;
  }
  const std::vector<Vec3> groups = forces.group_forces(state);
  EXPECT_GT(length(groups[1]), 1.0);
  EXPECT_LT(length(groups[0] + groups[1] - rate), 1e-10);
}

TEST(MotionRun, CountsZeroLengthSpringsAndInvertedTets) {
  const TetMesh mesh = build_kuhn_cube(1, 0.0, 1);
  const MotionModel model = make_free_body(mesh, 0.0);
  MotionState state = start_at_rest(model);
  const Edge onto = model.elastic.springs.springs.back();
  state.displacement_m[onto[0]] = mesh.points[onto[1]] - mesh.points[onto[0]];
  Integrator integrator(model, {});
  const MotionReport report = run_motion(integrator, state, {1e-6, 1});
  EXPECT_EQ(report.zero_length_springs, 1U);

  MotionState pierced = start_at_rest(model);
  pierced.displacement_m[0] = {3.0, 3.0, 3.0};  // through the whole cube
  const MotionReport inverted = run_motion(integrator, pierced, {1e-6, 1});
  EXPECT_GT(inverted.inverted_tets, 0U);
  EXPECT_EQ(inverted.inverted_tets, count_volume(model, pierced).inverted);
  EXPECT_EQ(inverted.first_inversion_s, 0.0);
  EXPECT_EQ(inverted.outcome, MotionOutcome::kInverted);
  EXPECT_EQ(inverted.state_hash, hash_state(pierced));
}

TEST(MotionRun, StopsAtTheFirstStateThatIsNotFiniteOrHasEscaped) {
  const MotionModel model = make_oscillator(1000.0, 0.0);
  Integrator integrator(model, {});
  MotionState state = start_at_rest(model);
  state.displacement_m[1].x = 0.01;
  const MotionReport report = run_motion(integrator, state, {1.0, 1000});
  EXPECT_EQ(report.outcome, MotionOutcome::kDiverged);
  EXPECT_LT(report.steps, 5U);
  EXPECT_EQ(report.first_bad_vertex, 1U);
  EXPECT_TRUE(report.is_finite);
  MotionState broken = start_at_rest(model);
  broken.velocity_m_s[1].y = kNotANumber;
  const MotionReport none = run_motion(integrator, broken, {1e-3, 10});
  EXPECT_EQ(none.outcome, MotionOutcome::kDiverged);
  EXPECT_EQ(none.steps, 0U);
  EXPECT_FALSE(none.is_finite);
}

TEST(MotionRun, ObservesAtTheStartEverySoOftenAndAtTheEnd) {
  const MotionModel model = make_oscillator(1.0, 0.0);
  Integrator integrator(model, {});
  MotionState state = start_at_rest(model);
  std::vector<std::uint64_t> seen;
  const auto note = [&](std::uint64_t step, const MotionState&) { seen.push_back(step); };
  const MotionReport report = run_motion(integrator, state, {0.1, 10, 1000.0, 4}, note);
  EXPECT_EQ(seen, (std::vector<std::uint64_t>{0, 4, 8, 10}));
  EXPECT_EQ(report.outcome, MotionOutcome::kCompleted);
  for (const double bad : {0.0, -0.1, kNotANumber})
    EXPECT_THROW(run_motion(integrator, state, {bad, 10}), InputError);
}

TEST(MotionRun, EndsWhereItIsToldToAndLooksAtTheLastState) {
  const MotionModel model = make_oscillator(1.0, 0.0);
  Integrator integrator(model, {});
  MotionState state = start_at_rest(model);
  state.displacement_m[1].x = 0.01;
  MotionState whole = state;
  std::vector<std::uint64_t> seen;
  MotionRunOptions options{0.1, 100, 1000.0, 4, {}};
  int asked = 0;
  options.should_stop = [&] { return ++asked > 6; };
  const MotionReport report = run_motion(
      integrator, state, options, [&](std::uint64_t step, const MotionState&) { seen.push_back(step); });
  EXPECT_EQ(report.outcome, MotionOutcome::kStopped);
  EXPECT_EQ(report.steps, 6U);
  EXPECT_EQ(seen, (std::vector<std::uint64_t>{0, 4, 6}));
  run_motion(integrator, whole, {0.1, 6});
  EXPECT_EQ(report.state_hash, hash_state(whole));
}

TEST(MotionRun, ADivergedStateThatIsFiniteIsSeenAndCounted) {
  const MotionModel model = make_oscillator(1000.0, 0.0);
  Integrator integrator(model, {});
  MotionState state = start_at_rest(model);
  state.displacement_m[1].x = 0.01;
  double last_m = 0.0;
  const MotionReport report =
      run_motion(integrator, state, {1.0, 1000},
                 [&](std::uint64_t, const MotionState& at) { last_m = length(at.displacement_m[1]); });
  EXPECT_EQ(report.outcome, MotionOutcome::kDiverged);
  EXPECT_EQ(last_m, length(state.displacement_m[1]));
  EXPECT_GT(last_m, 1000.0);
  EXPECT_EQ(report.peak_speed_m_s, length(state.velocity_m_s[1]));
}

TEST(MotionRun, StepsWithoutASolutionAreAnOutcome) {
  const MotionModel model = make_free_body(build_kuhn_cube(2, 0.2, 5), 0.02);
  for (const std::size_t iterations : {1U, 1000U}) {
    IntegratorOptions options;
    options.kind = IntegratorKind::kPrefactored;
    options.solver.iterations = iterations;
    Integrator integrator(model, options);
    MotionState state = start_at_rest(model);
    state.displacement_m = make_random_field(model.mass_kg.size(), 0.02, 1);
    const MotionReport report = run_motion(integrator, state, {0.01, 5});
    EXPECT_EQ(report.steps_unsolved, iterations == 1 ? 5U : 0U);
    EXPECT_EQ(report.outcome, iterations == 1 ? MotionOutcome::kUnsolved : MotionOutcome::kCompleted);
    EXPECT_STREQ(motion_outcome_name(report.outcome), iterations == 1 ? "unsolved" : "completed");
  }
}

TEST(MotionRun, APressedBodyFollowsItsToolAndComesBack) {
  const TetMesh mesh = build_kuhn_cube(2, 0.2, 5);
  MotionModel model = make_pressed_body(mesh, 1.0);
  model.loads[1].profile = {{0.0, 0.5, 1.0}, {0.0, 1.0, 0.0}, true};
  model.loads[0].loads.force_n.assign(mesh.points.size(), {});
  MotionState state = start_at_rest(model);
  Integrator integrator(model, {});
  double deepest = 0.0;
  const MotionReport report =
      run_motion(integrator, state, {1e-3, 30000, 1000.0, 100}, [&](std::uint64_t, const MotionState& at) {
        deepest = std::max(deepest, field_norm(at.displacement_m));
      });
  EXPECT_EQ(report.outcome, MotionOutcome::kCompleted);
  EXPECT_GT(deepest, 0.3);
  EXPECT_LT(field_norm(state.displacement_m), 1e-3 * deepest);
}

}  // namespace
}  // namespace palpate::dynamics

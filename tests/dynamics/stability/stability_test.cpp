#include "core/dynamics/stability/stability.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "core/dynamics/stability/extreme_eigen.h"
#include "core/mesh/shapes/shapes.h"
#include "tests/support/dynamics_cases.h"
#include "tests/support/motion_cases.h"

namespace palpate::dynamics {
namespace {

using namespace testing_support;

constexpr std::array<IntegratorKind, 4> kExplicit{
    IntegratorKind::kExplicitEuler, IntegratorKind::kSymplecticEuler, IntegratorKind::kVelocityVerlet,
    IntegratorKind::kRungeKutta4};

/// Whether a motion from `start` grows beyond `factor` times its first size within `steps`.
bool grows(const MotionModel& model, IntegratorKind kind, const MotionState& start, double step, int steps,
           double factor) {
  IntegratorOptions options;
  options.kind = kind;
  Integrator integrator(model, options);
  MotionState state = start;
  const double size = field_norm(start.displacement_m) + step * field_norm(start.velocity_m_s);
  for (int k = 0; k < steps; ++k) {
    integrator.step(state, step);
    if (!(field_norm(state.displacement_m) < factor * size)) return true;
  }
  return false;
}

TEST(Stability, TheBoundOfAModeIsWhereItStartsToGrow) {
  for (const double damping : {0.0, 0.5, 1.9, 2.1, 20.0}) {
    MotionModel model = make_oscillator(1.0, damping);
    model.elastic.springs_are_linear = true;
    MotionState start = start_at_rest(model);
    start.displacement_m[1].x = 1.0;
    for (const IntegratorKind kind : kExplicit) {
      if (kind == IntegratorKind::kExplicitEuler && damping == 0.0) continue;
      SCOPED_TRACE(std::string(integrator_name(kind)) + " damping " + std::to_string(damping));
      const double bound = stable_step_of_mode(kind, 1.0, damping);
      EXPECT_FALSE(grows(model, kind, start, 0.999 * bound, 20000, 50.0));
      EXPECT_TRUE(grows(model, kind, start, 1.002 * bound, 20000, 50.0));
    }
  }
}

TEST(Stability, KnownBoundsOfModes) {
  EXPECT_EQ(stable_step_of_mode(IntegratorKind::kExplicitEuler, 3.0, 0.0), 0.0);
  EXPECT_DOUBLE_EQ(stable_step_of_mode(IntegratorKind::kSymplecticEuler, 4.0, 0.0), 0.5);
  EXPECT_DOUBLE_EQ(stable_step_of_mode(IntegratorKind::kVelocityVerlet, 4.0, 0.0), 0.5);
  EXPECT_NEAR(stable_step_of_mode(IntegratorKind::kRungeKutta4, 4.0, 0.0), std::sqrt(8.0) / 4.0, 1e-9);
  EXPECT_NEAR(stable_step_of_mode(IntegratorKind::kRungeKutta4, 0.0, 4.0), 2.785293563405282 / 4.0, 1e-9);
  for (const IntegratorKind kind : kIntegrators)
    EXPECT_EQ(stable_step_of_mode(kind, 0.0, 0.0), std::numeric_limits<double>::infinity());
  EXPECT_EQ(stable_step_of_mode(IntegratorKind::kImplicitEuler, 1e9, 0.0),
            std::numeric_limits<double>::infinity());
  EXPECT_EQ(stable_step_of_mode(IntegratorKind::kPrefactored, 1e9, 0.0),
            std::numeric_limits<double>::infinity());
}

TEST(Stability, LargestEigenvalueOfALatticeOfSprings) {
  // A row of n equal masses on springs along x, free at both ends: 2 k (1 - cos(pi (n - 1) / n)).
  ElasticModel row;
  constexpr Index kCount = 40;
  for (Index v = 0; v < kCount; ++v) row.rest.push_back({static_cast<double>(v), 0.0, 0.0});
  for (Index v = 0; v + 1 < kCount; ++v) row.springs.springs.push_back({v, v + 1});
  row.springs.rest_length_m.assign(kCount - 1, 1.0);
  row.springs.stiffness_n_per_m.assign(kCount - 1, 3.0);
  BlockMatrix matrix = build_tangent_pattern(row, {});
  add_tangent(row, std::vector<Vec3>(kCount), TangentKind::kExact, matrix);
  const ExtremeEigen found = find_largest_eigenvalue(matrix, 1);
  ASSERT_TRUE(found.converged);
  EXPECT_NEAR(found.value, 6.0 * (1.0 - std::cos(std::numbers::pi * (kCount - 1.0) / kCount)), 1e-6);
}

TEST(Stability, AMatrixOfFewDifferentEigenvaluesHasItsLargest) {
  // A drag that is the same multiple of all masses, with some vertices held: eigenvalues 0 and 7 alone.
  ElasticModel points;
  for (Index v = 0; v < 30; ++v) points.rest.push_back({static_cast<double>(v), 0.0, 0.0});
  BlockMatrix matrix = build_tangent_pattern(points, {});
  for (std::size_t v = 0; v < 20; ++v) {
    for (std::size_t i = 0; i < 3; ++i) matrix.blocks[matrix.offsets[v]](i, i) = 7.0;
  }
  const ExtremeEigen found = find_largest_eigenvalue(matrix, 1);
  ASSERT_TRUE(found.converged);
  EXPECT_NEAR(found.value, 7.0, 1e-9);
  EXPECT_NEAR(field_norm(found.vector), 1.0, 1e-9);
}

class MassDamping : public ::testing::TestWithParam<int> {};

TEST_P(MassDamping, HasItsBound) {
  MotionModel model = make_free_body(build_kuhn_cube(GetParam(), 0.25, 5), 0.0);
  const double rate = 3.0 / predict_stable_step(model, IntegratorKind::kSymplecticEuler).step_s;
  for (const double m : model.mass_kg) model.environment_damping_n_s_per_m.push_back(rate * m);
  const double omega = 2.0 * rate / 3.0;
  for (const IntegratorKind kind : kExplicit) {
    const StableStep predicted = predict_stable_step(model, kind);
    EXPECT_TRUE(predicted.converged) << integrator_name(kind);
    const double fastest = stable_step_of_mode(kind, omega, rate);
    const double free = stable_step_of_mode(kind, 0.0, rate);  // the body's free motions have the drag alone
    EXPECT_NEAR(predicted.step_s / std::min(fastest, free), 1.0, 2e-3) << integrator_name(kind);
  }
}

INSTANTIATE_TEST_SUITE_P(Cells, MassDamping, ::testing::Values(1, 2, 3));

/// Bodies with no damping, Rayleigh damping, and damping that shares no vectors with the stiffness.
std::vector<MotionModel> make_bodies() {
  const TetMesh mesh = build_kuhn_cube(2, 0.25, 5);
  std::vector<MotionModel> bodies;
  for (const VolumeModel volume : {VolumeModel::kNone, VolumeModel::kNodeAverage}) {
    for (const double damping_s : {0.0, 0.02, 0.5}) {
      MotionModel model = make_pressed_body(mesh, 1.0, volume);
      model.elastic.springs_are_linear = true;
      for (StrainTerm& term : model.elastic.strain_terms) term.law = StrainLaw::kLinear;
      model.loads[0].loads.force_n.assign(mesh.points.size(), {});
      model.loads[1].profile = {};
      for (Vec3& by : model.loads[1].loads.held_by_m) by = {};
      for (std::size_t s = 0; s < model.spring_damping_n_s_per_m.size(); ++s)
        model.spring_damping_n_s_per_m[s] *= damping_s / 0.01 * (s % 3 == 0 ? 4.0 : 0.5);
      if (damping_s > 0.1) model.spring_damping = SpringDamping::kIsotropic;
      bodies.push_back(std::move(model));
    }
  }
  return bodies;
}

TEST(Stability, PredictedBoundsOfBodiesAreMeasuredWithinTwoPercent) {
  for (const MotionModel& model : make_bodies()) {
    MotionState start = start_at_rest(model);
    start.displacement_m = make_random_field(start.displacement_m.size(), 1e-3, 1);
    for (const IntegratorKind kind :
         {IntegratorKind::kSymplecticEuler, IntegratorKind::kVelocityVerlet, IntegratorKind::kRungeKutta4}) {
      const StableStep predicted = predict_stable_step(model, kind);
      SCOPED_TRACE(std::string(integrator_name(kind)) + " " + std::to_string(predicted.step_s));
      EXPECT_TRUE(predicted.converged);
      EXPECT_FALSE(grows(model, kind, start, 0.98 * predicted.step_s, 3000, 100.0));
      EXPECT_TRUE(grows(model, kind, start, 1.02 * predicted.step_s, 3000, 100.0));
    }
  }
}

// Damping by mass alone is a multiple of the identity: one eigenvalue, where Krylov's space has one
// dimension.
TEST(Stability, ABodyByItsMatricesHasTheSameBound) {
  MotionModel model = make_free_body(build_kuhn_cube(3, 0.2, 9), 2e-3);
  for (std::size_t v = 0; v < model.mass_kg.size(); ++v)
    model.mass_kg[v] *= 1.0 + 0.3 * static_cast<double>(v % 5);
  const std::vector<Vec3> rest(model.mass_kg.size());
  BlockMatrix stiffness = build_motion_pattern(model);
  BlockMatrix damping = stiffness;
  add_motion_stiffness(model, rest, TangentKind::kExact, stiffness);
  add_changing_damping(model, rest, damping);
  add_constant_damping(model, damping);
  for (const IntegratorKind kind : kExplicit) {
    const StableStep by_model = predict_stable_step(model, kind);
    const StableStep by_matrices = predict_stable_step(stiffness, damping, model.mass_kg, kind);
    EXPECT_EQ(by_model.step_s, by_matrices.step_s);
    // A body that is twice as heavy takes longer steps; explicit Euler goes by d / omega^2, which has no
    // mass.
    if (kind == IntegratorKind::kExplicitEuler) continue;
    std::vector<double> heavy = model.mass_kg;
    for (double& mass : heavy) mass *= 2.0;
    EXPECT_GT(predict_stable_step(stiffness, damping, heavy, kind).step_s, 1.01 * by_model.step_s);
  }
}

TEST(Stability, DampingByMassAlone) {
  MotionModel model = make_free_body(build_kuhn_cube(2, 0.25, 5), 0.0);
  const StableStep undamped = predict_stable_step(model, IntegratorKind::kSymplecticEuler);
  for (const double mass : model.mass_kg) model.environment_damping_n_s_per_m.push_back(60.0 * mass);
  const StableStep damped = predict_stable_step(model, IntegratorKind::kSymplecticEuler);
  EXPECT_TRUE(damped.converged);
  EXPECT_NEAR(damped.damping_max_per_s, 60.0, 1e-6);
  const double expected = stable_step_of_mode(IntegratorKind::kSymplecticEuler, 2.0 / undamped.step_s, 60.0);
  EXPECT_NEAR(damped.step_s, expected, 1e-3 * expected);
}

TEST(Stability, ExplicitEulerOfABodyNeedsDampingEverywhere) {
  const TetMesh mesh = build_kuhn_cube(2, 0.25, 5);
  MotionModel model = make_free_body(mesh, 0.2);
  model.elastic.springs_are_linear = true;
  MotionState start = start_at_rest(model);
  start.velocity_m_s = make_random_field(mesh.points.size(), 1e-3, 1);
  Vec3 drift;  // a rigid motion is not what grows
  for (const Vec3& v : start.velocity_m_s) drift = drift + (1.0 / 27.0) * v;
  for (Vec3& v : start.velocity_m_s) v = v - drift;
  const StableStep predicted = predict_stable_step(model, IntegratorKind::kExplicitEuler);
  // d = 0.2 omega^2 for all modes: h < 0.2 s, or 2 over the fastest rate.
  EXPECT_LE(predicted.step_s, 0.2 * (1.0 + 1e-9));
  IntegratorOptions options;
  options.kind = IntegratorKind::kExplicitEuler;
  const auto energy_after = [&](double step) {
    return measure_energy(model, march(model, options, start, 4000 * step, 4000)).total_j() /
           measure_energy(model, start).total_j();
  };
  EXPECT_LT(energy_after(0.98 * predicted.step_s), 1.0);
  EXPECT_GT(energy_after(1.02 * predicted.step_s), 100.0);
  model.spring_damping_n_s_per_m.clear();
  model.strain_damping_s = 0.0;
  EXPECT_EQ(predict_stable_step(model, IntegratorKind::kExplicitEuler).step_s, 0.0);
}

TEST(Stability, RowSumsBoundTheStepFromBelow) {
  for (const MotionModel& model : make_bodies()) {
    for (const IntegratorKind kind : kExplicit) {
      const double predicted = predict_stable_step(model, kind).step_s;
      const double bound = bound_stable_step(model, kind).step_s;
      EXPECT_LE(bound, predicted * (1.0 + 1e-3)) << integrator_name(kind);
      EXPECT_GE(bound, kind == IntegratorKind::kExplicitEuler ? 0.0 : 0.2 * predicted)
          << integrator_name(kind);
    }
    EXPECT_EQ(bound_stable_step(model, IntegratorKind::kImplicitEuler).step_s,
              std::numeric_limits<double>::infinity());
    EXPECT_EQ(predict_stable_step(model, IntegratorKind::kPrefactored).step_s,
              std::numeric_limits<double>::infinity());
  }
}

TEST(Stability, TheVertexThatLimitsTheStepIsNamed) {
  EXPECT_EQ(predict_stable_step(make_oscillator(3.0, 0.1), IntegratorKind::kSymplecticEuler).limiting_vertex,
            1U);
  // A vertex with a hundredth of its mass is ten times as fast as its neighbours.
  for (const double damping : {0.0, 1e-3}) {
    MotionModel model = make_free_body(build_kuhn_cube(4, 0.1, 3), damping);
    for (const Index light : {0U, 62U, 97U}) {
      const double mass = model.mass_kg[light];
      model.mass_kg[light] = 0.01 * mass;
      EXPECT_EQ(predict_stable_step(model, IntegratorKind::kSymplecticEuler).limiting_vertex, light);
      EXPECT_EQ(bound_stable_step(model, IntegratorKind::kVelocityVerlet).limiting_vertex, light);
      model.mass_kg[light] = mass;
    }
  }
  EXPECT_EQ(predict_stable_step(make_oscillator(0.0, 0.0), IntegratorKind::kSymplecticEuler).limiting_vertex,
            kNoIndex);
}

TEST(Stability, ThePredictionIsTheSameOnTwoThreads) {
  const MotionModel model = make_pressed_body(build_kuhn_cube(20, 0.2, 5), 1.0);
  const StableStep one = predict_stable_step(model, IntegratorKind::kSymplecticEuler, 1);
  EXPECT_EQ(predict_stable_step(model, IntegratorKind::kSymplecticEuler, 2).step_s, one.step_s);
}

/// The square of such a rate is no number; steps go as its inverse all the same.
TEST(Stability, TheStepOfAModeBeyondTheSquaresRangeIsItsInverse) {
  const double one = stable_step_of_mode(IntegratorKind::kRungeKutta4, 1.0, 0.0);
  EXPECT_NEAR(1e200 * stable_step_of_mode(IntegratorKind::kRungeKutta4, 1e200, 0.0) / one, 1.0, 1e-9);
  const double damped = stable_step_of_mode(IntegratorKind::kRungeKutta4, 1.0, 3.0);
  EXPECT_NEAR(1e200 * stable_step_of_mode(IntegratorKind::kRungeKutta4, 1e200, 3e200) / damped, 1.0, 1e-9);
}

}  // namespace
}  // namespace palpate::dynamics

#include "core/dynamics/integrators/integrator.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>

#include "core/base/error.h"
#include "core/mesh/shapes/shapes.h"
#include "tests/support/dynamics_cases.h"
#include "tests/support/motion_cases.h"

namespace palpate::dynamics {
namespace {

using namespace testing_support;

const std::map<IntegratorKind, double> kOrder{{IntegratorKind::kExplicitEuler, 1.0},
                                              {IntegratorKind::kSymplecticEuler, 1.0},
                                              {IntegratorKind::kVelocityVerlet, 2.0},
                                              {IntegratorKind::kRungeKutta4, 4.0},
                                              {IntegratorKind::kImplicitEuler, 1.0},
                                              {IntegratorKind::kPrefactored, 1.0},
                                              {IntegratorKind::kBackwardEuler, 1.0},
                                              {IntegratorKind::kBdf2, 2.0},
                                              {IntegratorKind::kTrapezoidal, 2.0},
                                              {IntegratorKind::kXpbd, 1.0},
                                              {IntegratorKind::kVbd, 1.0}};

IntegratorOptions options_of(IntegratorKind kind) {
  IntegratorOptions options;
  options.kind = kind;
  options.solver = {300, 1e-9};
  return options;
}

MotionState pulled_oscillator(const MotionModel& model, double start_m) {
  MotionState state = start_at_rest(model);
  state.displacement_m[1].x = start_m;
  return state;
}

double energy_of(const MotionModel& model, const MotionState& state) {
  return measure_energy(model, state).total_j();
}

double distance(const MotionState& a, const MotionState& b) {
  return field_distance(a.displacement_m, b.displacement_m) + field_distance(a.velocity_m_s, b.velocity_m_s);
}

TEST(Integrator, EachOrderOfConvergenceAgainstTheDampedOscillator) {
  const double omega = 3.0;
  const double damping = 0.8;
  const MotionModel model = make_oscillator(omega, damping);
  const MotionState start = pulled_oscillator(model, 0.1);
  const double exact = oscillator_at(omega, damping, 0.1, 1.0);
  for (const IntegratorKind kind : kIntegrators) {
    const double order = kOrder.at(kind);
    SCOPED_TRACE(integrator_name(kind));
    const std::uint64_t steps = order == 1.0 ? 2000 : (order == 2.0 ? 800 : 80);
    const auto error = [&](std::uint64_t n) {
      return std::abs(march(model, options_of(kind), start, 1.0, n).displacement_m[1].x - exact);
    };
    // The next term of the error is about h omega of the first.
    EXPECT_NEAR(std::log2(error(steps) / error(2 * steps)), order, 0.1);
  }
}

TEST(Integrator, EachOrderOfConvergenceAgainstAFineReferenceOfAPressedBody) {
  const TetMesh mesh = build_kuhn_cube(2, 0.2, 5);
  const double duration = 0.2;
  for (const VolumeModel volume : {VolumeModel::kNone, VolumeModel::kNodeAverage}) {
    const MotionModel model = make_pressed_body(mesh, duration, volume);
    const MotionState start = start_at_rest(model);
    const MotionState fine = march(model, options_of(IntegratorKind::kRungeKutta4), start, duration, 1000);
    for (const IntegratorKind kind : kIntegrators) {
      const double order = kOrder.at(kind);
      SCOPED_TRACE(integrator_name(kind));
      const std::uint64_t steps = order == 4.0 ? 80 : 160;
      const auto error = [&](std::uint64_t n) {
        return distance(march(model, options_of(kind), start, duration, n), fine);
      };
      EXPECT_NEAR(std::log2(error(steps) / error(2 * steps)), order, 0.2);
    }
  }
}

TEST(Integrator, TheEnergyOfTheSymplecticOnesStaysBoundedOverAMillionSteps) {
  // They keep v^2 + omega^2 x^2 - h omega^2 x v and v^2 + omega^2 x^2 (1 - (h omega)^2 / 4) of an oscillator,
  // so that the energy stays within the factors below.
  const double omega = 2.0;
  const double step = 0.05;
  const MotionModel model = make_oscillator(omega, 0.0);
  const double p = step * omega;
  const std::map<IntegratorKind, double> band{
      {IntegratorKind::kSymplecticEuler, (1.0 + 0.5 * p) / (1.0 - 0.5 * p)},
      {IntegratorKind::kVelocityVerlet, 1.0 / (1.0 - 0.25 * p * p)}};
  for (const auto& [kind, factor] : band) {
    SCOPED_TRACE(integrator_name(kind));
    Integrator integrator(model, options_of(kind));
    MotionState state = pulled_oscillator(model, 0.1);
    const double start = energy_of(model, state);
    double least = start;
    double most = start;
    for (int k = 0; k < 1'000'000; ++k) {
      integrator.step(state, step);
      if (k % 101 != 0 && k < 999'000) continue;
      least = std::min(least, energy_of(model, state));
      most = std::max(most, energy_of(model, state));
    }
    EXPECT_LE(most / start, factor * (1.0 + 1e-9));
    EXPECT_GE(least / start, (1.0 - 1e-9) / factor);
    EXPECT_GT(most / least, 1.0 + 0.5 * (factor - 1.0)) << "the band is not loose";
  }
}

TEST(Integrator, ExplicitEulerGainsEnergyAsTheoryHasIt) {
  // Every step of an undamped oscillator multiplies its energy by 1 + (h omega)^2.
  const MotionModel model = make_oscillator(2.0, 0.0);
  const MotionState start = pulled_oscillator(model, 0.1);
  const MotionState end = march(model, options_of(IntegratorKind::kExplicitEuler), start, 5.0, 1000);
  EXPECT_NEAR(energy_of(model, end) / energy_of(model, start), std::pow(1.0 + 1e-4, 1000), 1e-9);
}

TEST(Integrator, AFreeBodyKeepsItsMomentum) {
  const TetMesh mesh = build_kuhn_cube(2, 0.2, 5);
  const MotionModel model = make_free_body(mesh, 0.02);
  MotionState start = start_at_rest(model);
  start.displacement_m = make_random_field(mesh.points.size(), 0.02, 1);
  start.velocity_m_s = make_random_field(mesh.points.size(), 0.5, 2);
  const Vec3 before = measure_momentum(model, start);
  for (const IntegratorKind kind : kIntegrators) {
    SCOPED_TRACE(integrator_name(kind));
    IntegratorOptions options = options_of(kind);
    // Vertex by vertex nothing pairs the forces: momentum is as exact as the steps are solved.
    if (kind == IntegratorKind::kVbd) options.solver = {2000, 1e-13};
    const MotionState end = march(model, options, start, 0.2, 100);
    EXPECT_GT(field_distance(start.velocity_m_s, end.velocity_m_s), 0.1);
    // 1000 kg at about 0.5 m/s, rounded some thousand times. Of kVbd a hundred steps of 2 ms, each solved to
    // what rounding leaves: some 1e-9 N a vertex.
    EXPECT_LT(length(measure_momentum(model, end) - before), kind == IntegratorKind::kVbd ? 1e-8 : 1e-9);
  }
}

Vec3 spin_of(const MotionModel& model, const MotionState& state) {
  Vec3 sum;
  for (std::size_t v = 0; v < model.mass_kg.size(); ++v)
    sum = sum +
          model.mass_kg[v] * cross(model.elastic.rest[v] + state.displacement_m[v], state.velocity_m_s[v]);
  return sum;
}

TEST(Integrator, AxialDampingLeavesARotationAloneAndIsotropicDampingBrakesIt) {
  const TetMesh mesh = build_kuhn_cube(2, 0.2, 5);
  MotionModel model = make_free_body(mesh, 0.02);
  MotionState start = start_at_rest(model);
  for (std::size_t v = 0; v < mesh.points.size(); ++v)
    start.velocity_m_s[v] = cross({0.0, 0.0, 0.5}, mesh.points[v] - Vec3{0.5, 0.5, 0.5});
  const IntegratorOptions options = options_of(IntegratorKind::kSymplecticEuler);
  const double before = length(spin_of(model, start));
  EXPECT_NEAR(length(spin_of(model, march(model, options, start, 1.0, 400))) / before, 1.0, 1e-12);
  model.spring_damping = SpringDamping::kIsotropic;
  EXPECT_LT(length(spin_of(model, march(model, options, start, 1.0, 400))) / before, 0.9);
}

TEST(Integrator, DampingRatesAreThoseOfTheory) {
  const double omega = 4.0;
  const double damping = 0.2;
  const MotionModel model = make_oscillator(omega, damping);
  const double period = 2.0 * std::numbers::pi / std::sqrt(omega * omega - 0.25 * damping * damping);
  const MotionState start = pulled_oscillator(model, 0.1);
  const MotionState end = march(model, options_of(IntegratorKind::kRungeKutta4), start, 5.0 * period, 2000);
  EXPECT_NEAR(energy_of(model, end) / energy_of(model, start), std::exp(-damping * 5.0 * period), 1e-9);

  // A free body that flies through its environment: m v' = -gamma v, (1 - h gamma / m)^n for symplectic
  // Euler.
  const TetMesh mesh = build_kuhn_cube(1, 0.0, 1);
  MotionModel flying = make_free_body(mesh, 0.0);
  for (const double mass : flying.mass_kg) flying.environment_damping_n_s_per_m.push_back(0.5 * mass);
  MotionState fast = start_at_rest(flying);
  for (Vec3& v : fast.velocity_m_s) v = {1.0, 2.0, 3.0};
  const MotionState slow = march(flying, options_of(IntegratorKind::kSymplecticEuler), fast, 1.0, 100);
  for (const Vec3& v : slow.velocity_m_s) EXPECT_NEAR(v.y, 2.0 * std::pow(1.0 - 0.005, 100), 1e-12);
}

TEST(Integrator, OneThreadAndTwoGiveTheSameBits) {
  const TetMesh mesh = build_kuhn_cube(20, 0.2, 5);  // 9261 vertices: enough for two ranges
  for (const VolumeModel volume : {VolumeModel::kNone, VolumeModel::kNodeAverage}) {
    const MotionModel model = make_pressed_body(mesh, 0.1, volume);
    MotionState start = start_at_rest(model);
    start.velocity_m_s = make_random_field(mesh.points.size(), 0.1, 3);
    for (const IntegratorKind kind : kIntegrators) {
      if (volume != VolumeModel::kNone && kind != IntegratorKind::kSymplecticEuler) continue;
      SCOPED_TRACE(integrator_name(kind));
      IntegratorOptions options = options_of(kind);
      options.solver = {1, 0.0};
      options.linear.tolerance = 1e-2;
      const std::uint64_t one = hash_state(march(model, options, start, 1e-3, 1));
      options.threads = 2;
      options.linear.threads = 2;
      EXPECT_EQ(hash_state(march(model, options, start, 1e-3, 1)), one);
      if (kind != IntegratorKind::kSymplecticEuler) continue;
      EXPECT_NE(hash_state(march(model, options, start, 1.1e-3, 1)), one) << "the hash sees a difference";
    }
  }
}

TEST(Integrator, ImplicitOnesHoldAStepThatExplicitOnesCannot) {
  const TetMesh mesh = build_kuhn_cube(2, 0.2, 5);
  MotionModel model = make_pressed_body(mesh, 1.0);
  const MotionState start = start_at_rest(model);
  for (const IntegratorKind kind : kIntegrators) {
    SCOPED_TRACE(integrator_name(kind));
    const MotionState end = march(model, options_of(kind), start, 100.0, 50);
    const double size = field_norm(end.displacement_m);
    EXPECT_EQ(std::isfinite(size) && size < 10.0, is_implicit(kind));
  }
}

TEST(Integrator, TheSpeedLimitCutsAndCounts) {
  const MotionModel model = make_oscillator(10.0, 0.0);
  IntegratorOptions options = options_of(IntegratorKind::kSymplecticEuler);
  options.speed_limit_m_s = 0.5;
  Integrator integrator(model, options);
  MotionState state = pulled_oscillator(model, 0.1);
  std::size_t cut = 0;
  for (int k = 0; k < 100; ++k) {
    cut += integrator.step(state, 0.005).speeds_cut;
    EXPECT_LE(std::abs(state.velocity_m_s[1].x), 0.5 + 1e-15);
  }
  EXPECT_GT(cut, 0U);
  EXPECT_LT(cut, 100U);
  options.speed_limit_m_s = -1.0;
  EXPECT_THROW(Integrator(model, options), InputError);
}

TEST(Integrator, NamesAreReadBackAndOthersRefused) {
  for (const IntegratorKind kind : kIntegrators) EXPECT_EQ(parse_integrator(integrator_name(kind)), kind);
  EXPECT_THROW(parse_integrator("verlet"), InputError);
}

TEST(Integrator, WhatHasNoEnergyIsRefusedByThoseThatNeedOne) {
  const TetMesh mesh = build_kuhn_cube(1, 0.0, 1);
  MotionModel model = make_free_body(mesh, 0.1, VolumeModel::kThesis);
  for (const IntegratorKind kind :
       {IntegratorKind::kPrefactored, IntegratorKind::kXpbd, IntegratorKind::kVbd})
    EXPECT_THROW(Integrator(model, options_of(kind)), InputError);
  EXPECT_NO_THROW(Integrator(model, options_of(IntegratorKind::kBackwardEuler)));

  model = make_free_body(mesh, 0.1);
  model.spring_damping = SpringDamping::kIsotropic;
  EXPECT_THROW(Integrator(model, options_of(IntegratorKind::kXpbd)), InputError);
  EXPECT_NO_THROW(Integrator(model, options_of(IntegratorKind::kVbd)));
  model = make_free_body(mesh, 0.1, VolumeModel::kNodeAverage);
  model.elastic.strain_terms.front().law = StrainLaw::kNeoHookean;
  EXPECT_THROW(Integrator(model, options_of(IntegratorKind::kXpbd)), InputError);
}

}  // namespace
}  // namespace palpate::dynamics

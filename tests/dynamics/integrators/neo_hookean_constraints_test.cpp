// XPBD with neo-Hookean tetrahedra: its two constraints, one tetrahedron in closed form, rest and momentum.
#include "core/dynamics/integrators/neo_hookean_constraints.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/dynamics/integrators/integrator.h"
#include "core/dynamics/stability/stability.h"
#include "core/mesh/shapes/shapes.h"
#include "tests/support/dynamics_cases.h"
#include "tests/support/law_cases.h"
#include "tests/support/motion_cases.h"

namespace palpate::dynamics {
namespace {

using namespace testing_support;

constexpr StrainLaw kLaw = StrainLaw::kStableNeoHookean;

/// The largest difference of `slope` from a central difference of the constraint of volume at h.
double slope_error(const Mat3& h, const Mat3& slope) {
  const double step = std::cbrt(2e-16);
  double worst = 0.0;
  for (std::size_t i = 0; i < 9; ++i) {
    Mat3 more = h;
    Mat3 less = h;
    more.m[i] += step;
    less.m[i] -= step;
    const double wanted =
        (hydrostatic_constraint(kModuli, more).value - hydrostatic_constraint(kModuli, less).value) /
        (2.0 * step);
    worst = std::max(worst, std::abs(slope.m[i] - wanted));
  }
  return worst;
}

TEST(NeoHookeanConstraints, TheSlopeOfTheVolumeIsItsDerivative) {
  SplitMix64 random(1);
  for (int k = 0; k < 50; ++k) {
    const Mat3 h = random_matrix(random, 0.8);  // some are turned inside out
    EXPECT_LT(slope_error(h, hydrostatic_constraint(kModuli, h).slope), 1e-8);
    // One without its transpose is told apart.
    EXPECT_GT(slope_error(h, transpose(cofactors(kIdentity + h))), 1e-3);
  }
}

TEST(NeoHookeanConstraints, TheirEnergiesAreThatOfTheLaw) {
  SplitMix64 random(2);
  const auto energy_of = [](const Mat3& h) {
    const double volume = hydrostatic_constraint(kModuli, h).value;
    const Mat3 f = kIdentity + h;
    return 0.5 * kModuli.mu_pa * contract(f, f) + 0.5 * (kModuli.lambda_pa + kModuli.mu_pa) * volume * volume;
  };
  for (int k = 0; k < 50; ++k) {
    const Mat3 h = random_matrix(random, 0.8);
    EXPECT_NEAR(energy_of(h) - energy_of({}), energy_density(kLaw, kModuli, h), 1e-13);
  }
}

/// A tetrahedron with its base on z = 0, light and dragged, so that a step of 1 s is all but at rest.
MotionModel make_one_tet(const Vec3& force_n) {
  const TetMesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.3, 0.2, 0.5}}, {{0, 1, 2, 3}}};
  MotionModel model;
  model.tets = mesh.tets;
  model.elastic.rest = mesh.points;
  model.elastic.strain_terms.push_back(
      {build_strain_operator(mesh, StrainDomain::kTet), {3000.0, 1000.0}, kLaw});
  model.mass_kg.assign(4, 1.0);
  model.environment_damping_n_s_per_m.assign(4, 10.0);
  Loads loads{std::vector<Vec3>(4), {}, {7, 7, 7, 0}, std::vector<Vec3>(4)};
  loads.force_n[3] = force_n;
  model.loads.push_back({loads, {}});
  return model;
}

IntegratorOptions xpbd_options(std::size_t iterations, double tolerance) {
  IntegratorOptions options;
  options.kind = IntegratorKind::kXpbd;
  options.solver = {iterations, tolerance};
  return options;
}

TEST(NeoHookeanConstraints, OneTetrahedronComesToItsClosedForm) {
  // F = I + u (x) g, g = e_z / 0.5: V W = V (mu/2 |u|^2 |g|^2 + (lambda + mu)/2 (u . g)^2), however far it is
  // moved: f = V |g|^2 (mu u + (lambda + mu) u_z e_z).
  const double per_m = (0.5 / 6.0) * 4.0;
  for (const Vec3& force : {Vec3{0, 0, 300}, Vec3{0, 0, -900}, Vec3{200, 100, 0}, Vec3{-150, 250, 500}}) {
    const MotionModel model = make_one_tet(force);
    const MotionState end = march(model, xpbd_options(200, 1e-12), start_at_rest(model), 20.0, 200);
    const Vec3 wanted{force.x / (per_m * 1000.0), force.y / (per_m * 1000.0), force.z / (per_m * 5000.0)};
    EXPECT_LT(length(end.displacement_m[3] - wanted), 1e-9 * length(wanted)) << force.x << ' ' << force.z;
    // Lame's moduli with lambda in the place of lambda + mu, as is easily taken, are told apart.
    const Vec3 soft{wanted.x, wanted.y, force.z / (per_m * 4000.0)};
    if (force.z != 0.0) {
      EXPECT_GT(length(end.displacement_m[3] - soft), 0.05 * length(soft));
    }
  }
}

TEST(NeoHookeanConstraints, ATetrahedronTurnedInsideOutComesBack) {
  const MotionModel model = make_one_tet({});
  MotionState state = start_at_rest(model);
  state.displacement_m[3] = {0.1, 0.0, -0.9};  // J = -0.8
  EXPECT_EQ(count_volume(model, state).inverted, 1U);
  state = march(model, xpbd_options(200, 1e-12), state, 60.0, 60);
  EXPECT_LT(length(state.displacement_m[3]), 1e-9);
}

MotionModel make_free_tets(StrainLaw law) {
  const TetMesh mesh = build_kuhn_cube(2, 0.2, 5);
  return make_continuum(make_free_body(mesh, 0.0), mesh, Continuum::kTets, law);
}

TEST(NeoHookeanConstraints, RestStaysAtRest) {
  const MotionModel model = make_free_tets(kLaw);
  const double stable_s = predict_stable_step(model, IntegratorKind::kSymplecticEuler, 1).step_s;
  for (const double factor : {0.1, 1.0, 10.0, 100.0}) {
    for (const std::size_t sweeps : {1, 5}) {
      const MotionState end =
          march(model, xpbd_options(sweeps, 0.0), start_at_rest(model), 100.0 * factor * stable_s, 100);
      // Two forces of h^2 mu V |g| cancel at each vertex: rounding is of their size over the mass, which is
      // that of factor^2 on a cube of 1 m.
      EXPECT_LT(field_norm(end.displacement_m),
                100.0 * 100.0 * factor * factor * std::numeric_limits<double>::epsilon())
          << factor << ' ' << sweeps;
    }
  }
}

Vec3 moment_of_change(const MotionModel& model, const MotionState& before, const MotionState& after) {
  Vec3 sum;
  for (std::size_t v = 0; v < model.mass_kg.size(); ++v) {
    const Vec3 change = model.mass_kg[v] * (after.velocity_m_s[v] - before.velocity_m_s[v]);
    sum = sum + cross(model.elastic.rest[v] + after.displacement_m[v], change);
  }
  return sum;
}

TEST(NeoHookeanConstraints, MomentumIsKept) {
  for (const double damping_s : {0.0, 0.05}) {
    MotionModel model = make_free_tets(kLaw);
    model.strain_damping_s = damping_s;
    MotionState state = start_at_rest(model);
    state.velocity_m_s = make_random_field(model.mass_kg.size(), 1.0, 5);
    const Vec3 momentum = measure_momentum(model, state);
    double size = 0.0;
    for (std::size_t v = 0; v < model.mass_kg.size(); ++v)
      size += model.mass_kg[v] * length(state.velocity_m_s[v]);
    Integrator once(model, xpbd_options(1, 0.0));
    MotionState swept = state;
    for (int k = 0; k < 20; ++k) once.step(swept, 0.05);
    EXPECT_LT(length(measure_momentum(model, swept) - momentum), 1e-12 * size);
    // The forces at the end of a step have no moment there, so a step that is swept to the end has none.
    Integrator solved(model, xpbd_options(2000, damping_s == 0.0 ? 1e-11 : 0.0));
    for (int k = 0; k < 3 && damping_s == 0.0; ++k) {
      const MotionState before = state;
      EXPECT_TRUE(solved.step(state, 0.02).solved);
      EXPECT_LT(length(moment_of_change(model, before, state)), 1e-9 * size);
      EXPECT_LT(length(measure_momentum(model, state) - momentum), 1e-12 * size);
    }
  }
  // One that leaves half of the forces out of balance does not keep the moment.
  const MotionModel model = make_free_tets(kLaw);
  MotionState state = start_at_rest(model);
  state.velocity_m_s = make_random_field(model.mass_kg.size(), 1.0, 5);
  const MotionState before = state;
  Integrator once(model, xpbd_options(1, 0.0));
  once.step(state, 0.05);
  EXPECT_GT(length(moment_of_change(model, before, state)), 1e-6);
}

TEST(NeoHookeanConstraints, WhatHasNoSquaresIsRefused) {
  EXPECT_THROW(Integrator(make_free_tets(StrainLaw::kNeoHookean), xpbd_options(1, 0.0)), InputError);
  MotionModel model = make_free_tets(kLaw);
  for (const Moduli& moduli : {Moduli{1000.0, -1.0}, Moduli{-1000.0, 1000.0}, Moduli{}}) {
    model.elastic.strain_terms.front().moduli = moduli;
    EXPECT_THROW(Integrator(model, xpbd_options(1, 0.0)), InputError);
  }
}

}  // namespace
}  // namespace palpate::dynamics

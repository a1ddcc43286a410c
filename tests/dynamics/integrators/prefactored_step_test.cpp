#include "core/dynamics/integrators/prefactored_step.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "core/dynamics/integrators/integrator.h"
#include "core/dynamics/stability/stability.h"
#include "core/mesh/shapes/shapes.h"
#include "tests/support/dynamics_cases.h"
#include "tests/support/motion_cases.h"

namespace palpate::dynamics {
namespace {

using namespace testing_support;

IntegratorOptions fixed_iterations(std::size_t iterations) {
  IntegratorOptions options;
  options.kind = IntegratorKind::kPrefactored;
  options.solver = {iterations, 0.0};
  return options;
}

/// A free cube of a continuum near incompressibility.
MotionModel make_soft_cube(Continuum kind, StrainLaw law, double lambda_over_mu) {
  const TetMesh mesh = build_kuhn_cube(2, 0.2, 5);
  MotionModel model = make_continuum(make_free_body(mesh, 0.0), mesh, kind, law);
  model.strain_damping_s = 0.0;
  for (StrainTerm& term : model.elastic.strain_terms)
    term.moduli.lambda_pa = lambda_over_mu * term.moduli.mu_pa;
  return model;
}

MotionState thrown(const MotionModel& model, double speed_m_s) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> number(-speed_m_s, speed_m_s);
  MotionState state = start_at_rest(model);
  for (Vec3& v : state.velocity_m_s) v = {number(random), number(random), number(random)};
  return state;
}

// nu = 0.25, 0.45 and 0.49. The weight 2 mu + lambda, less than half of 2 mu + 3 lambda, grew at the last
// two.
TEST(PrefactoredStep, NoStepMakesTheEnergyOfAContinuumGrow) {
  for (const double lambda_over_mu : {1.0, 9.0, 49.0}) {
    for (const Continuum kind : {Continuum::kTets, Continuum::kEdgeNode}) {
      for (const StrainLaw law : {StrainLaw::kLinear, StrainLaw::kCorotated, StrainLaw::kStableNeoHookean}) {
        const MotionModel model = make_soft_cube(kind, law, lambda_over_mu);
        const double bound = predict_stable_step(model, IntegratorKind::kSymplecticEuler).step_s;
        for (const double factor : {1.0, 10.0, 100.0, 1e4}) {
          for (const std::size_t iterations : {2U, 5U}) {
            Integrator integrator(model, fixed_iterations(iterations));
            MotionState state = thrown(model, 1e-3 / bound);  // thousandths of the cube in a stable step
            const double start = measure_energy(model, state).total_j();
            double most = 0.0;
            for (int k = 0; k < 60; ++k) {
              integrator.step(state, factor * bound);
              most = std::max(most, measure_energy(model, state).total_j());
            }
            EXPECT_LT(most, 2.0 * start) << lambda_over_mu << ' ' << static_cast<int>(law) << ' ' << factor
                                         << ' ' << iterations << " iterations";
          }
        }
      }
    }
  }
}

// What five iterations leave of a bending bar's motion, by one integrator and by one that is made anew for
// each step.
TEST(PrefactoredStep, WhatWasLearntInEarlierStepsIsNotForgotten) {
  const TetMesh mesh = build_kuhn_cube(3, 0.2, 5);
  const MotionModel model =
      make_continuum(make_pressed_body(mesh, 0.3), mesh, Continuum::kEdgeNode, StrainLaw::kCorotated);
  const double step_s = 0.1;
  IntegratorOptions solver = fixed_iterations(2000);
  solver.solver.tolerance = 1e-8;
  const MotionState wanted = march(model, solver, start_at_rest(model), 2.0, 20);
  const MotionState kept = march(model, fixed_iterations(3), start_at_rest(model), 2.0, 20);
  MotionState forgetful = start_at_rest(model);
  for (int k = 0; k < 20; ++k) Integrator(model, fixed_iterations(3)).step(forgetful, step_s);
  const auto off = [&](const MotionState& end) {
    return field_distance(end.displacement_m, wanted.displacement_m) / field_norm(wanted.displacement_m);
  };
  EXPECT_LT(off(kept), 0.5 * off(forgetful));
}

}  // namespace
}  // namespace palpate::dynamics

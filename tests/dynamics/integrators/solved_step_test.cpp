// Steps that are solved within: one equation, whoever solves it.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/base/error.h"
#include "core/dynamics/integrators/integrator.h"
#include "core/dynamics/integrators/step_balance.h"
#include "core/mesh/shapes/shapes.h"
#include "tests/support/dynamics_cases.h"
#include "tests/support/motion_cases.h"

namespace palpate::dynamics {
namespace {

using namespace testing_support;

constexpr std::array kOfOneEquation{IntegratorKind::kBackwardEuler, IntegratorKind::kPrefactored,
                                    IntegratorKind::kXpbd, IntegratorKind::kVbd};

IntegratorOptions solved_options(IntegratorKind kind, std::size_t iterations, double tolerance) {
  IntegratorOptions options;
  options.kind = kind;
  options.solver = {iterations, tolerance};
  return options;
}

FacePatch whole_faces_at(const TetMesh& mesh, int axis, double at) {
  FacePatch patch{find_faces_at(mesh, axis, at), {}};
  patch.weight.assign(patch.faces.size(), 1.0);
  return patch;
}

/// A cube on an elastic bed, pressed from above by another, under gravity.
MotionModel make_bedded_body(const TetMesh& mesh, VolumeModel volume) {
  MotionModel model = make_free_body(mesh, 0.0, volume);
  for (std::size_t s = 0; s < model.elastic.springs.springs.size(); ++s)
    model.spring_damping_n_s_per_m[s] = 0.02 * model.elastic.springs.stiffness_n_per_m[s];
  model.environment_damping_n_s_per_m = model.mass_kg;
  BoundaryProblem bed;
  bed.material.density_kg_m3 = 1000.0;
  bed.gravity_m_s2 = {0.0, 0.5, -1.0};
  bed.supports.push_back({whole_faces_at(mesh, 2, 0.0), 1e4, {}});
  BoundaryProblem pad;
  pad.supports.push_back({whole_faces_at(mesh, 2, 1.0), 2e4, {0.05, 0.0, -0.1}});
  model.loads.push_back({build_loads(mesh, bed), {}});
  model.loads.push_back({build_loads(mesh, pad), {{0.0, 0.3}, {0.0, 1.0}, true}});
  return model;
}

void linearise_all(MotionModel& model) {
  model.elastic.springs_are_linear = true;
  for (StrainTerm& term : model.elastic.strain_terms) term.law = StrainLaw::kLinear;
}

TEST(SolvedStep, SolversOfOneEquationAgree) {
  const TetMesh mesh = build_kuhn_cube(2, 0.2, 5);
  for (const VolumeModel volume : {VolumeModel::kNone, VolumeModel::kNodeAverage, VolumeModel::kTet}) {
    SCOPED_TRACE(volume_model_name(volume));
    for (const int which : {0, 1, 2, 3}) {
      const bool is_bedded = which % 2 == 0;
      const bool is_linear = which / 2 == 1;
      SCOPED_TRACE(which);
      MotionModel model = is_bedded ? make_bedded_body(mesh, volume) : make_pressed_body(mesh, 0.3, volume);
      model.strain_damping_s = 0.01;
      if (is_linear) linearise_all(model);
      const double tolerance = 1e-9;
      const MotionState start = start_at_rest(model);
      const MotionState wanted =
          march(model, solved_options(IntegratorKind::kBackwardEuler, 50, tolerance), start, 0.3, 6);
      EXPECT_GT(field_norm(wanted.displacement_m), 0.1);
      for (const IntegratorKind kind : kOfOneEquation) {
        if (kind == IntegratorKind::kXpbd && !is_linear) continue;
        SCOPED_TRACE(integrator_name(kind));
        Integrator integrator(model, solved_options(kind, 20000, tolerance));
        MotionState state = start;
        for (int k = 0; k < 6; ++k) EXPECT_TRUE(integrator.step(state, 0.05).solved);
        // What is out of balance by 1e-9 moves the body by that share of what the forces do, times how much
        // softer it is against a smooth force than against a rough one: some hundred in this cube.
        EXPECT_LT(field_distance(state.displacement_m, wanted.displacement_m),
                  1e-6 * field_norm(wanted.displacement_m));
      }
    }
  }
}

TEST(SolvedStep, NeoHookeanPositionsConvergeToTheSameEquation) {
  const TetMesh mesh = build_kuhn_cube(2, 0.2, 5);
  for (const Continuum kind : {Continuum::kTets, Continuum::kEdgeNode}) {
    MotionModel model =
        make_continuum(make_bedded_body(mesh, VolumeModel::kNone), mesh, kind, StrainLaw::kStableNeoHookean);
    model.strain_damping_s = 0.0;
    const MotionState start = start_at_rest(model);
    const double tolerance = 1e-9;
    const auto newton = solved_options(IntegratorKind::kBackwardEuler, 50, tolerance);
    const MotionState wanted = march(model, newton, start, 0.3, 6);
    Integrator integrator(model, solved_options(IntegratorKind::kXpbd, 20000, tolerance));
    MotionState state = start;
    for (int k = 0; k < 6; ++k) EXPECT_TRUE(integrator.step(state, 0.05).solved);
    EXPECT_LT(field_distance(state.displacement_m, wanted.displacement_m),
              1e-6 * field_norm(wanted.displacement_m));
    // Another law of the same moduli is told apart.
    for (StrainTerm& term : model.elastic.strain_terms) term.law = StrainLaw::kNeoHookean;
    EXPECT_GT(field_distance(march(model, newton, start, 0.3, 6).displacement_m, wanted.displacement_m),
              1e-3 * field_norm(wanted.displacement_m));
  }
}

TEST(SolvedStep, WhatPositionsConvergeToComesNearerAsStepsGrowShorter) {
  const TetMesh mesh = build_kuhn_cube(2, 0.2, 5);
  for (const VolumeModel volume : {VolumeModel::kNone, VolumeModel::kNodeAverage}) {
    SCOPED_TRACE(volume_model_name(volume));
    MotionModel model = make_bedded_body(mesh, volume);
    model.strain_damping_s = 0.0;
    const auto off = [&](std::uint64_t steps) {
      const MotionState start = start_at_rest(model);
      const MotionState wanted =
          march(model, solved_options(IntegratorKind::kBackwardEuler, 50, 1e-9), start, 0.3, steps);
      const MotionState found =
          march(model, solved_options(IntegratorKind::kXpbd, 300, 0.0), start, 0.3, steps);
      return field_distance(found.displacement_m, wanted.displacement_m) / field_norm(wanted.displacement_m);
    };
    const double coarse = off(6);
    EXPECT_LT(coarse, 1e-2);
    // A correction turns a constraint by the share of its length that a step moves it, so a step is off by
    // the square of that at the least.
    EXPECT_LT(off(24), 0.25 * coarse);
  }
}

TEST(SolvedStep, AnotherEquationsSolutionIsToldApart) {
  const TetMesh mesh = build_kuhn_cube(2, 0.2, 5);
  const MotionModel model = make_bedded_body(mesh, VolumeModel::kNone);
  const MotionState start = start_at_rest(model);
  const auto end = [&](IntegratorKind kind) {
    return march(model, solved_options(kind, 50, 1e-9), start, 0.3, 6).displacement_m;
  };
  const std::vector<Vec3> wanted = end(IntegratorKind::kBackwardEuler);
  EXPECT_GT(field_distance(end(IntegratorKind::kTrapezoidal), wanted), 1e-3 * field_norm(wanted));
  EXPECT_GT(field_distance(end(IntegratorKind::kImplicitEuler), wanted), 1e-5 * field_norm(wanted));
}

TEST(SolvedStep, ALinearBodyTakesOneSolutionAStep) {
  const TetMesh mesh = build_kuhn_cube(2, 0.2, 5);
  MotionModel model = make_bedded_body(mesh, VolumeModel::kNodeAverage);
  linearise_all(model);
  for (const IntegratorKind kind :
       {IntegratorKind::kBackwardEuler, IntegratorKind::kBdf2, IntegratorKind::kTrapezoidal}) {
    SCOPED_TRACE(integrator_name(kind));
    Integrator integrator(model, solved_options(kind, 10, 1e-9));
    MotionState state = start_at_rest(model);
    for (int k = 0; k < 20; ++k) {
      const StepReport report = integrator.step(state, k < 10 ? 0.02 : 0.03);
      EXPECT_TRUE(report.solved);
      EXPECT_EQ(report.iterations, 1U) << k;
    }
  }
}

/// Too many blocks for a factorisation that is thrown away: a body's factors are made once for each length of
/// step, and steps by conjugate gradients come to the same.
TEST(SolvedStep, ALinearBodyIsFactoredOnceForEachLengthOfStep) {
  const TetMesh mesh = build_kuhn_cube(6, 0.2, 5);
  MotionModel model = make_bedded_body(mesh, VolumeModel::kNodeAverage);
  model.strain_damping_s = 0.01;
  linearise_all(model);
  const MotionState start = start_at_rest(model);
  ASSERT_GT(build_motion_pattern(model).blocks.size(), 4000);
  for (const IntegratorKind kind :
       {IntegratorKind::kBackwardEuler, IntegratorKind::kTrapezoidal, IntegratorKind::kImplicitEuler}) {
    SCOPED_TRACE(integrator_name(kind));
    IntegratorOptions options = solved_options(kind, 50, 1e-9);
    options.linear.method = LinearMethod::kConjugateGradients;
    options.linear.tolerance = 1e-13;
    const MotionState wanted = march(model, options, start, 0.2, 10);
    int calls = 0;
    options.linear.method = LinearMethod::kAuto;
    options.linear.factor = [&calls](const LowerHalf& matrix) {
      ++calls;
      return factor_simplicial(matrix);
    };
    Integrator integrator(model, options);
    MotionState state = start;
    for (int step = 0; step < 10; ++step) {
      const StepReport report = integrator.step(state, 0.02);
      EXPECT_TRUE(report.solved);
      EXPECT_LE(report.iterations, 1);
    }
    EXPECT_EQ(calls, 1);
    EXPECT_LT(field_distance(state.displacement_m, wanted.displacement_m),
              1e-6 * field_norm(wanted.displacement_m));
    integrator.step(state, 0.01);
    integrator.step(state, 0.01);
    EXPECT_EQ(calls, 2);
  }
}

TEST(SolvedStep, TheTrapezoidalRuleKeepsTheEnergyOfALinearBodyAndTheOthersLoseIt) {
  // It keeps quadratic invariants exactly. Backward Euler divides the energy of a mode by 1 + (h omega)^2 a
  // step.
  const double omega = 3.0;
  const double step = 0.1;
  MotionModel model = make_oscillator(omega, 0.0);
  model.elastic.springs_are_linear = true;
  const auto energy_after = [&](IntegratorKind kind, int steps) {
    Integrator integrator(model, solved_options(kind, 10, 1e-12));
    MotionState state = start_at_rest(model);
    state.displacement_m[1].x = 0.1;
    const double start = measure_energy(model, state).total_j();
    for (int k = 0; k < steps; ++k) integrator.step(state, step);
    return measure_energy(model, state).total_j() / start;
  };
  EXPECT_NEAR(energy_after(IntegratorKind::kTrapezoidal, 1000), 1.0, 1e-10);
  EXPECT_NEAR(energy_after(IntegratorKind::kBackwardEuler, 50),
              std::pow(1.0 + omega * omega * step * step, -50.0), 1e-10);
  // The two-step formula loses less, but loses: of z^2 = 1 - (h omega)^2 (its characteristic equation) it is
  // the principal root.
  const double bdf2 = energy_after(IntegratorKind::kBdf2, 50);
  EXPECT_LT(bdf2, 0.999);
  EXPECT_GT(bdf2, energy_after(IntegratorKind::kBackwardEuler, 50));
}

TEST(SolvedStep, WhatIsLeftIsReportedAndOutOfIterationsIsAnOutcome) {
  const TetMesh mesh = build_kuhn_cube(2, 0.2, 5);
  const MotionModel model = make_bedded_body(mesh, VolumeModel::kNodeAverage);
  for (const IntegratorKind kind : kOfOneEquation) {
    SCOPED_TRACE(integrator_name(kind));
    const auto first = [&](std::size_t iterations, double tolerance) {
      Integrator integrator(model, solved_options(kind, iterations, tolerance));
      MotionState state = start_at_rest(model);
      return integrator.step(state, 0.1);
    };
    const StepReport few = first(1, 1e-9);
    EXPECT_FALSE(few.solved);
    EXPECT_EQ(few.iterations, 1U);
    ASSERT_TRUE(few.residual_relative.has_value());
    EXPECT_GT(*few.residual_relative, 1e-9);
    const StepReport fixed = first(1, 0.0);
    EXPECT_TRUE(fixed.solved) << "so many iterations are what was asked for";
    EXPECT_NEAR(*fixed.residual_relative, *few.residual_relative, 1e-12);
    const StepReport more = first(50, 0.0);
    EXPECT_LT(*more.residual_relative, 0.5 * *few.residual_relative);
    const StepReport enough = first(5000, 1e-9);
    EXPECT_EQ(enough.solved, *enough.residual_relative <= 1e-9);
    EXPECT_EQ(enough.solved, kind != IntegratorKind::kXpbd) << "it stops short of a body whose springs turn";
  }
}

TEST(SolvedStep, ASystemThatWasNotSolvedIsNoSolvedStep) {
  const TetMesh mesh = build_kuhn_cube(2, 0.2, 5);
  const MotionModel model = make_bedded_body(mesh, VolumeModel::kNodeAverage);
  for (const double tolerance : {0.0, 1e-9}) {
    IntegratorOptions options = solved_options(IntegratorKind::kBackwardEuler, 5, tolerance);
    options.linear.method = LinearMethod::kConjugateGradients;
    const auto first = [&] {
      Integrator integrator(model, options);
      MotionState state = start_at_rest(model);
      return integrator.step(state, 0.1);
    };
    EXPECT_TRUE(first().solved) << tolerance;
    options.linear.max_iterations = 1;
    const StepReport broken = first();
    EXPECT_FALSE(broken.solved) << tolerance;
    EXPECT_EQ(broken.iterations, 1U);
  }
}

TEST(SolvedStep, NewtonsMethodConvergesQuadratically) {
  const TetMesh mesh = build_kuhn_cube(2, 0.2, 5);
  const MotionModel model = make_bedded_body(mesh, VolumeModel::kNodeAverage);
  std::vector<double> left;
  for (std::size_t iterations = 1; iterations <= 12; ++iterations) {
    Integrator integrator(model, solved_options(IntegratorKind::kBackwardEuler, iterations, 1e-10));
    MotionState state = start_at_rest(model);
    state.displacement_m = make_random_field(mesh.points.size(), 0.02, 1);
    left.push_back(*integrator.step(state, 0.1).residual_relative);
  }
  // From 1e-2 on each iteration doubles the digits, with a constant that depends on the body.
  for (std::size_t k = 1; k < left.size(); ++k) {
    if (left[k - 1] >= 1e-2 || left[k] <= 1e-9) continue;
    EXPECT_LT(left[k], 50.0 * left[k - 1] * left[k - 1]) << k;
  }
  EXPECT_LT(left.back(), 1e-9);
}

TEST(SolvedStep, SubstepsAreStepsOfTheirOwn) {
  const TetMesh mesh = build_kuhn_cube(2, 0.2, 5);
  const MotionModel model = make_bedded_body(mesh, VolumeModel::kNone);
  for (const IntegratorKind kind : {IntegratorKind::kXpbd, IntegratorKind::kVbd}) {
    SCOPED_TRACE(integrator_name(kind));
    IntegratorOptions options = solved_options(kind, 3, 0.0);
    const MotionState one_by_one = march(model, options, start_at_rest(model), 0.3, 24);
    options.substeps = 4;
    const MotionState in_fours = march(model, options, start_at_rest(model), 0.3, 6);
    EXPECT_LT(field_distance(in_fours.displacement_m, one_by_one.displacement_m),
              1e-10 * field_norm(one_by_one.displacement_m));
    EXPECT_NEAR(in_fours.time_s, 0.3, 1e-12);
  }
}

TEST(SolvedStep, StrainDampingTurnsWithTheBody) {
  // A spinning body loses no spin to damping but what a step of Newton's and a rotation of finite size leave.
  const TetMesh mesh = build_kuhn_cube(2, 0.2, 5);
  MotionModel model = make_free_body(mesh, 0.05, VolumeModel::kNodeAverage);
  MotionState start = start_at_rest(model);
  for (std::size_t v = 0; v < mesh.points.size(); ++v)
    start.velocity_m_s[v] = cross({0.0, 0.0, 0.05}, mesh.points[v] - Vec3{0.5, 0.5, 0.5});
  const auto kinetic = [&](double damping_s, double drag_per_s, IntegratorKind kind) {
    MotionModel damped = model;
    damped.strain_damping_s = damping_s;
    for (const double mass : model.mass_kg) damped.environment_damping_n_s_per_m.push_back(drag_per_s * mass);
    const MotionState end = march(damped, solved_options(kind, 200, 1e-10), start, 0.5, 50);
    return measure_energy(damped, end).kinetic_j;
  };
  for (const IntegratorKind kind : kOfOneEquation) {
    SCOPED_TRACE(integrator_name(kind));
    const double without = kinetic(0.0, 0.0, kind);
    EXPECT_NEAR(kinetic(0.05, 0.0, kind) / without, 1.0, 1e-3);
    EXPECT_LT(kinetic(0.0, 1.0, kind) / without, 0.5) << "drag is felt";
  }
}

/// A free body let go from an extreme: stretched, turned inside out, or collapsed to a point (`to` times its
/// size along x, or along all axes).
MotionState let_go_from(const MotionModel& model, double to, bool all_axes) {
  MotionState state = start_at_rest(model);
  for (std::size_t v = 0; v < model.elastic.rest.size(); ++v) {
    const Vec3& x = model.elastic.rest[v];
    state.displacement_m[v] = (to - 1.0) * (all_axes ? x : Vec3{x.x, 0.0, 0.0});
  }
  return state;
}

/// Each vertex is moved to where the step's energy, elastic energy + m / (2 h^2) |u' - guess|^2 of a free
/// body, is no higher. So without damping it is at most what it was at the guess u + h v, after any number of
/// sweeps; or, where that has no energy, at the displacements before. Dampers have no such energy in large
/// motions: there the sum of elastic and kinetic energy may not double, where a method that overshoots ends
/// in no number.
void expect_descent(const MotionModel& model, MotionState state, double step_s, int steps, bool is_damped) {
  Integrator integrator(model, solved_options(IntegratorKind::kVbd, 3, 0.0));
  const double first = measure_energy(model, state).total_j();
  for (int k = 0; k < steps; ++k) {
    std::vector<Vec3> guess = state.displacement_m;
    for (std::size_t v = 0; v < guess.size(); ++v) guess[v] = guess[v] + step_s * state.velocity_m_s[v];
    double given = elastic_energy(model.elastic, guess);
    if (!std::isfinite(given)) given = measure_energy(model, state).total_j();
    integrator.step(state, step_s);
    ASSERT_LE(measure_energy(model, state).total_j(), 2.0 * first) << k;
    double left = elastic_energy(model.elastic, state.displacement_m);
    for (std::size_t v = 0; v < guess.size(); ++v)
      left += 0.5 * model.mass_kg[v] * length_sq((1.0 / step_s) * (state.displacement_m[v] - guess[v]));
    if (!is_damped) {
      ASSERT_LE(left, (1.0 + 1e-9) * given) << k;
    }
  }
}

TEST(SolvedStep, VertexDescentGoesDownFromAnyExtreme) {
  const TetMesh mesh = build_kuhn_cube(2, 0.2, 5);
  for (const StrainLaw law :
       {StrainLaw::kStableNeoHookean, StrainLaw::kNeoHookean, StrainLaw::kCorotated, StrainLaw::kLinear}) {
    SCOPED_TRACE(strain_law_name(law));
    MotionModel model = make_continuum(make_free_body(mesh, 0.0), mesh, Continuum::kTets, law);
    for (const double to : {2.0, 11.0, 30.0, 100.0, -1.0, -30.0, 0.01, 0.0}) {
      if (law == StrainLaw::kNeoHookean && to <= 0.0) continue;  // it has no energy there
      for (const bool all_axes : {false, true}) {
        for (const double damping_s : {0.0, 0.1, 10.0}) {
          model.strain_damping_s = damping_s;
          for (const double step_s : {1e-3, 0.03, 1.0}) {
            SCOPED_TRACE(testing::Message() << to << (all_axes ? " all axes, " : " along x, ") << damping_s
                                            << " s, step " << step_s);
            expect_descent(model, let_go_from(model, to, all_axes), step_s, 8, damping_s > 0.0);
          }
        }
      }
    }
  }
}

TEST(SolvedStep, VertexDescentOfSpringsGoesDownFromAnyExtreme) {
  const TetMesh mesh = build_kuhn_cube(2, 0.2, 5);
  for (const double damping_s : {0.0, 0.01, 1.0}) {
    const MotionModel model = make_free_body(mesh, damping_s);
    for (const double to : {11.0, 100.0, -1.0, 0.01}) {
      for (const double step_s : {1e-3, 0.03, 1.0}) {
        SCOPED_TRACE(testing::Message() << to << ", " << damping_s << " s, step " << step_s);
        expect_descent(model, let_go_from(model, to, true), step_s, 8, damping_s > 0.0);
      }
    }
  }
}

TEST(SolvedStep, VertexDescentStillSolvesStepsOfAStretchedDampedBody) {
  const TetMesh mesh = build_kuhn_cube(2, 0.2, 5);
  for (const StrainLaw law : {StrainLaw::kStableNeoHookean, StrainLaw::kNeoHookean}) {
    SCOPED_TRACE(strain_law_name(law));
    MotionModel model = make_continuum(make_free_body(mesh, 0.0), mesh, Continuum::kTets, law);
    model.strain_damping_s = 0.01;
    MotionState state = let_go_from(model, 11.0, false);
    Integrator integrator(model, solved_options(IntegratorKind::kVbd, 5000, 1e-8));
    for (int k = 0; k < 5; ++k) EXPECT_TRUE(integrator.step(state, 0.01).solved) << k;
  }
}

TEST(SolvedStep, TheRoundingFloorIsThatOfAnUnloadedBodyMovedAside) {
  // A rigid displacement has no forces but what rounding makes of large ones.
  const TetMesh mesh = build_kuhn_cube(3, 0.2, 5);
  const MotionModel model = make_free_body(mesh, 0.0, VolumeModel::kNodeAverage);
  MotionForces forces(model, 1);
  MotionState state = start_at_rest(model);
  for (Vec3& u : state.displacement_m) u = {0.3, -0.2, 0.1};
  std::vector<Vec3> velocity(mesh.points.size());
  std::vector<Vec3> imbalance(mesh.points.size());
  find_imbalance(forces, state, 0.01, state.displacement_m, velocity, imbalance);
  const double floor = RoundingFloor(forces).of(state.displacement_m, 0.01);
  EXPECT_LT(field_norm(imbalance) * std::sqrt(static_cast<double>(mesh.points.size())), floor);
  const std::vector<Vec3> rough = make_random_field(mesh.points.size(), 0.3, 2);
  find_imbalance(forces, state, 0.01, rough, velocity, imbalance);
  EXPECT_LT(floor, 1e-13 * field_norm(imbalance) * std::sqrt(static_cast<double>(mesh.points.size())));
}

}  // namespace
}  // namespace palpate::dynamics

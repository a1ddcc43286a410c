#include "core/dynamics/statics/static_equilibrium.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/dynamics/elasticity/volume_models.h"
#include "core/dynamics/statics/tangent_system.h"
#include "core/mesh/geometry.h"
#include "core/mesh/shapes/shapes.h"
#include "tests/support/dynamics_cases.h"
#include "tests/support/small_meshes.h"

namespace palpate::dynamics {
namespace {

using testing_support::field_distance;
using testing_support::field_norm;
using testing_support::find_faces_at;
using testing_support::make_edge_springs;

FacePatch whole(std::vector<Triangle> faces) {
  FacePatch patch{std::move(faces), {}};
  patch.weight.assign(patch.faces.size(), 1.0);
  return patch;
}

/// Rollers on the three faces through the origin: no rigid motion is left, and no stress is made.
std::vector<HeldFaces> rollers(const TetMesh& mesh) {
  std::vector<HeldFaces> held;
  held.reserve(3);
  for (int axis = 0; axis < 3; ++axis)
    held.push_back({find_faces_at(mesh, axis, 0.0), {axis == 0, axis == 1, axis == 2}, {}});
  return held;
}

/// A bar of 4 x 1 x 1 m pulled at its far end by `traction`.
BoundaryProblem pulled_bar(const TetMesh& mesh, const Material& material, StrainSize strain,
                           double traction) {
  BoundaryProblem problem;
  problem.material = material;
  problem.strain = strain;
  problem.held = rollers(mesh);
  problem.tractions.push_back({whole(find_faces_at(mesh, 0, 4.0)), {traction, 0.0, 0.0}, 0.0});
  return problem;
}

ElasticModel springs_of(const TetMesh& mesh, double young, StrainSize strain) {
  return {mesh.points, make_edge_springs(mesh, young), strain == StrainSize::kSmall, {}, {}};
}

TEST(StaticEquilibrium, ABlendPassesThePatchTestToRounding) {
  // A bar under uniform tension: u = (s x, -nu s y, -nu s z), s = traction / E, whatever theta and domain
  // are.
  const TetMesh mesh = build_bar(3);
  for (const double nu : {0.0, 0.25, 0.49}) {
    const Material material{2000.0, nu, 1000.0};
    const Loads loads = build_loads(mesh, pulled_bar(mesh, material, StrainSize::kSmall, 20.0));
    const double s = 0.01;
    const Mat3 gradient{{s, 0, 0, 0, -nu * s, 0, 0, 0, -nu * s}};
    const std::vector<Vec3> exact = testing_support::make_affine_field(mesh.points, gradient, {});
    for (const StrainDomain domain : {StrainDomain::kNode, StrainDomain::kEdge, StrainDomain::kFace}) {
      for (const LinearMethod method : {LinearMethod::kDirect, LinearMethod::kConjugateGradients}) {
        const BuiltModel built = build_blend_model(
            mesh, material, {StrainSize::kSmall, StrainLaw::kCorotated, 0.85, domain, StrainDomain::kTet});
        StaticOptions options;
        options.linearised = true;
        options.linear.method = method;
        const StaticSolution solution = solve_static(mesh, built.model, loads, options);
        ASSERT_EQ(solution.report.outcome, StaticOutcome::kConverged);
        EXPECT_LT(field_distance(solution.displacement_m, exact), 1e-9 * field_norm(exact)) << "nu " << nu;
        // 1/2 traction s V
        EXPECT_NEAR(solution.report.elastic_energy_j, 0.5 * 20.0 * s * 4.0, 1e-9);
      }
    }
  }
}

TEST(StaticEquilibrium, NeoHookeanTensionHasItsClosedForm) {
  // One stretch along the bar, one across: P_xx = mu (a - 1/a) + lambda ln(a b^2) / a = t and 0 = mu (b -
  // 1/b) + lambda ln(a b^2) / b.
  const TetMesh mesh = build_bar(2);
  const Material material{1000.0, 0.4, 1000.0};
  const double a = 1.3;
  double b = 1.0;
  for (int k = 0; k < 50; ++k) {  // Newton on the transverse equation, times b
    const double f = material.mu_pa() * (b * b - 1.0) + material.lambda_pa() * std::log(a * b * b);
    b -= f / (2.0 * material.mu_pa() * b + 2.0 * material.lambda_pa() / b);
  }
  const double traction = material.mu_pa() * (a - 1.0 / a) + material.lambda_pa() * std::log(a * b * b) / a;
  const Loads loads = build_loads(mesh, pulled_bar(mesh, material, StrainSize::kLarge, traction));
  const BuiltModel built = build_blend_model(mesh, material, {StrainSize::kLarge});
  StaticOptions options;
  options.tolerance = 1e-12;
  const StaticSolution solution = solve_static(mesh, built.model, loads, options);
  ASSERT_EQ(solution.report.outcome, StaticOutcome::kConverged);
  const Mat3 gradient{{a - 1.0, 0, 0, 0, b - 1.0, 0, 0, 0, b - 1.0}};
  const std::vector<Vec3> exact = testing_support::make_affine_field(mesh.points, gradient, {});
  EXPECT_LT(field_distance(solution.displacement_m, exact), 1e-9 * field_norm(exact));
}

TEST(StaticEquilibrium, NewtonConvergesQuadratically) {
  const TetMesh mesh = build_bar(2);
  const Material material{1000.0, 0.4, 1000.0};
  BoundaryProblem problem;
  problem.material = material;
  problem.held.push_back({find_faces_at(mesh, 0, 0.0), {true, true, true}, {}});
  problem.tractions.push_back({whole(find_faces_at(mesh, 0, 4.0)), {0.0, 0.0, -4.0}, 0.0});
  const Loads loads = build_loads(mesh, problem);
  std::vector<ElasticModel> models{springs_of(mesh, 1000.0, StrainSize::kLarge),
                                   build_blend_model(mesh, material, {StrainSize::kLarge}).model};
  for (const VolumeModel volume :
       {VolumeModel::kTet, VolumeModel::kNodeAverage, VolumeModel::kNodeSmoothed}) {
    models.push_back(build_spring_model(mesh, make_edge_springs(mesh, 2.5 * material.mu_pa()), material,
                                        {volume, StrainSize::kLarge})
                         .model);
  }
  models.push_back(build_spring_model(mesh, make_edge_springs(mesh, 1000.0), material,
                                      {VolumeModel::kThesis, StrainSize::kLarge})
                       .model);
  for (const ElasticModel& model : models) {
    StaticOptions options;
    options.tolerance = 1e-12;
    options.linear.method = LinearMethod::kDirect;
    const StaticSolution solution = solve_static(mesh, model, loads, options);
    ASSERT_EQ(solution.report.outcome, StaticOutcome::kConverged);
    const std::vector<double>& r = solution.report.residuals;
    ASSERT_GE(r.size(), 4U);
    // Each residual near the end is at most a constant times the square of the one before.
    for (std::size_t k = 1; k < r.size(); ++k) {
      if (r[k - 1] < 1e-2 && r[k - 1] > 1e-7) {
        EXPECT_LT(r[k], 300.0 * r[k - 1] * r[k - 1] + 1e-13) << "iterate " << k;
      }
    }
    // The bar's end really turns: what follows is not the linear answer.
    StaticOptions once = options;
    once.linearised = true;
    const std::vector<Vec3> linear = solve_static(mesh, model, loads, once).displacement_m;
    EXPECT_GT(field_distance(linear, solution.displacement_m), 0.02 * field_norm(linear));
  }
}

TEST(StaticEquilibrium, IterationsGiveWhatTheFactorisationGives) {
  const TetMesh mesh = build_bar(3);
  const Material material{1000.0, 0.45, 1000.0};
  BoundaryProblem problem;
  problem.material = material;
  problem.gravity_m_s2 = {0.0, 0.01, -0.02};
  problem.supports.push_back({whole(find_faces_at(mesh, 0, 0.0)), 1e4, {}});
  problem.supports.push_back({whole(find_faces_at(mesh, 0, 4.0)), 1e3, {0.0, 0.2, 0.1}});
  const Loads loads = build_loads(mesh, problem);
  for (const bool linearised : {true, false}) {
    const StrainSize strain = linearised ? StrainSize::kSmall : StrainSize::kLarge;
    const BuiltModel built = build_spring_model(mesh, make_edge_springs(mesh, 2.5 * material.mu_pa()),
                                                material, {VolumeModel::kNodeSmoothed, strain});
    StaticOptions options;
    options.linearised = linearised;
    options.tolerance = 1e-11;
    options.linear.method = LinearMethod::kDirect;
    const StaticSolution direct = solve_static(mesh, built.model, loads, options);
    options.linear.method = LinearMethod::kConjugateGradients;
    const StaticSolution iterated = solve_static(mesh, built.model, loads, options);
    options.linear.threads = 2;
    const StaticSolution two_threads = solve_static(mesh, built.model, loads, options);
    ASSERT_EQ(direct.report.outcome, StaticOutcome::kConverged);
    ASSERT_EQ(iterated.report.outcome, StaticOutcome::kConverged);
    EXPECT_GT(iterated.report.linear_iterations, 0U);
    EXPECT_LT(field_distance(direct.displacement_m, iterated.displacement_m),
              1e-7 * field_norm(direct.displacement_m));
    EXPECT_EQ(iterated.displacement_m, two_threads.displacement_m);
  }
}

TEST(StaticEquilibrium, SupportsCarryTheConsistentFaceMass) {
  // A stiff block on an elastic bed, pushed by p: it sinks by p / kappa as a whole, and turned by a linear p
  // it turns as a rigid body would.
  const TetMesh mesh = build_kuhn_cube(2, 0.0, 1);
  const Material material{1e9, 0.25, 1000.0};
  BoundaryProblem problem;
  problem.material = material;
  problem.supports.push_back({whole(find_faces_at(mesh, 2, 0.0)), 50.0, {0.1, 0.0, 0.0}});
  problem.tractions.push_back({whole(find_faces_at(mesh, 2, 1.0)), {0.0, 0.0, 0.0}, 5.0});
  const BuiltModel built = build_blend_model(mesh, material, {});
  StaticOptions options;
  options.linearised = true;
  const StaticSolution solution = solve_static(mesh, built.model, build_loads(mesh, problem), options);
  for (const Vec3& u : solution.displacement_m) {
    EXPECT_NEAR(u.x, 0.1, 1e-7);
    EXPECT_NEAR(u.y, 0.0, 1e-7);
    EXPECT_NEAR(u.z, -0.1, 1e-7);
  }
  // A couple M of two nodal forces about y: the bed answers with kappa I phi, I = integral of x^2 = 1/12 -
  // exact for the consistent mass, 1/8 where a face of 4 triangles were lumped.
  BoundaryProblem couple;
  couple.material = material;
  couple.supports.push_back({whole(find_faces_at(mesh, 2, 0.0)), 50.0, {}});
  for (Index v = 0; v < mesh.points.size(); ++v) {
    const Vec3& p = mesh.points[v];
    if (p.z == 1.0 && p.y == 0.5 && p.x != 0.5)
      couple.nodal_forces.push_back({v, {0, 0, p.x < 0.5 ? 0.01 : -0.01}});
  }
  ASSERT_EQ(couple.nodal_forces.size(), 2U);
  const StaticSolution turned = solve_static(mesh, built.model, build_loads(mesh, couple), options);
  const double angle = 0.01 / (50.0 / 12.0);
  for (Index v = 0; v < mesh.points.size(); ++v)
    EXPECT_NEAR(turned.displacement_m[v].z, -angle * (mesh.points[v].x - 0.5), 1e-6 * angle);
}

TEST(StaticEquilibrium, HeldFacesArriveWhereTheyAreHeld) {
  const TetMesh mesh = build_bar(2);
  BoundaryProblem problem;
  problem.material = {1000.0, 0.25, 1000.0};
  problem.held.push_back({find_faces_at(mesh, 0, 0.0), {true, true, true}, {}});
  problem.held.push_back({find_faces_at(mesh, 0, 4.0), {true, true, true}, {0.5, 0.0, 1.0}});
  const Loads loads = build_loads(mesh, problem);
  for (const bool linearised : {true, false}) {
    for (const LinearMethod method : {LinearMethod::kDirect, LinearMethod::kConjugateGradients}) {
      StaticOptions options;
      options.linearised = linearised;
      options.linear.method = method;
      options.load_steps = 2;
      const StaticSolution solution =
          solve_static(mesh, springs_of(mesh, 1000.0, linearised ? StrainSize::kSmall : StrainSize::kLarge),
                       loads, options);
      ASSERT_EQ(solution.report.outcome, StaticOutcome::kConverged);
      for (Index v = 0; v < mesh.points.size(); ++v) {
        if (mesh.points[v].x == 0.0) {
          EXPECT_EQ(solution.displacement_m[v], (Vec3{}));
        }
        if (mesh.points[v].x == 4.0) {
          EXPECT_LT(length(solution.displacement_m[v] - Vec3{0.5, 0.0, 1.0}), 1e-15);
        }
      }
    }
  }
}

TEST(StaticEquilibrium, ASlenderBarBuckles) {
  // Pushed along its axis far beyond Euler's load, pi^2 E I / (4 L^2) = 0.0128 E at 4 x 1 x 1, and held
  // straight by symmetry alone: an equilibrium, but not a stable one.
  const TetMesh mesh = build_bcc_bar(2);
  BoundaryProblem problem;
  problem.material = {1000.0, 0.25, 1000.0};
  problem.held.push_back({find_faces_at(mesh, 0, 0.0), {true, true, true}, {}});
  const BuiltModel built =
      build_blend_model(mesh, problem.material, {StrainSize::kLarge, StrainLaw::kCorotated});
  const auto push = [&](double pressure, LinearMethod method) {
    BoundaryProblem pushed = problem;
    pushed.tractions.push_back({whole(find_faces_at(mesh, 0, 4.0)), {-pressure, 0.0, 0.0}, 0.0});
    StaticOptions options;
    options.linear.method = method;
    return solve_static(mesh, built.model, build_loads(mesh, pushed), options);
  };
  for (const LinearMethod method : {LinearMethod::kDirect, LinearMethod::kConjugateGradients}) {
    EXPECT_EQ(push(6.0, method).report.outcome, StaticOutcome::kConverged);
    const StaticSolution beyond = push(30.0, method);
    const bool left_the_axis = std::any_of(beyond.displacement_m.begin(), beyond.displacement_m.end(),
                                           [](const Vec3& u) { return std::hypot(u.y, u.z) > 0.5; });
    EXPECT_TRUE(beyond.report.outcome == StaticOutcome::kBuckled || left_the_axis)
        << static_outcome_name(beyond.report.outcome);
    EXPECT_GT(
        beyond.report.indefinite_tangents + (beyond.report.outcome == StaticOutcome::kBuckled ? 1U : 0U), 0U);
  }
}

TEST(StaticEquilibrium, InvertedTetsAreAnOutcome) {
  // A corner vertex is pushed through the opposite face: springs let it.
  const TetMesh mesh = testing_support::make_corner_tet();
  BoundaryProblem problem;
  problem.material = {1000.0, 0.25, 1000.0};
  problem.held.push_back({{{0, 2, 1}}, {true, true, true}, {}});
  problem.nodal_forces.push_back({3, {0.0, 0.0, -20000.0}});
  const StaticSolution solution =
      solve_static(mesh, springs_of(mesh, 1000.0, StrainSize::kLarge), build_loads(mesh, problem), {});
  EXPECT_EQ(solution.report.outcome, StaticOutcome::kInverted);
  EXPECT_EQ(solution.report.inverted_tets, 1U);
  EXPECT_LT(solution.report.least_volume_ratio, 0.0);
  StaticOptions once;
  once.linearised = true;  // small strain knows no such bound, but says what it did
  const StaticReport linear =
      solve_static(mesh, springs_of(mesh, 1000.0, StrainSize::kSmall), build_loads(mesh, problem), once)
          .report;
  EXPECT_EQ(linear.outcome, StaticOutcome::kConverged);
  EXPECT_EQ(linear.inverted_tets, 1U);
  EXPECT_LT(linear.least_volume_ratio, 0.0);
}

TEST(StaticEquilibrium, SpringsThatHoldNothingEndAsAnOutcome) {
  const TetMesh mesh = build_bar(1);
  BoundaryProblem problem;
  problem.material = {1000.0, 0.25, 1000.0};
  problem.gravity_m_s2 = {0.0, 0.0, -9.81};
  problem.held.push_back({find_faces_at(mesh, 0, 0.0), {true, true, true}, {}});
  const Loads loads = build_loads(mesh, problem);
  ElasticModel model = springs_of(mesh, 1000.0, StrainSize::kLarge);
  std::fill(model.springs.stiffness_n_per_m.begin(), model.springs.stiffness_n_per_m.end(), 0.0);
  for (const bool linearised : {true, false}) {
    for (const LinearMethod method : {LinearMethod::kDirect, LinearMethod::kConjugateGradients}) {
      StaticOptions options;
      options.linearised = linearised;
      options.linear.method = method;
      const StaticSolution solution = solve_static(mesh, model, loads, options);
      EXPECT_NE(solution.report.outcome, StaticOutcome::kConverged);
      for (const Vec3& u : solution.displacement_m) EXPECT_TRUE(is_finite(u));
    }
  }
}

TEST(StaticEquilibrium, TheVolumeForcesTangentIsExact) {
  const TetMesh mesh = build_kuhn_cube(2, 0.2, 3);
  BuiltModel built = build_spring_model(mesh, make_edge_springs(mesh, 1000.0), {1000.0, 0.25, 1.0},
                                        {VolumeModel::kThesis, StrainSize::kLarge});
  const Loads loads = build_loads(mesh, {});
  const std::vector<Vec3> u = testing_support::make_random_field(mesh.points.size(), 0.05, 1);
  const std::vector<Vec3> direction = testing_support::make_random_field(mesh.points.size(), 1.0, 2);
  TangentSystem system(built.model, loads, {});
  system.prepare(u, TangentKind::kExact, 0.0);
  std::vector<Vec3> exact(u.size());
  system.apply(direction, exact);
  const double step = 1e-6;
  std::vector<Vec3> off = exact;
  for (const double sign : {1.0, -1.0}) {
    std::vector<Vec3> there(u);
    for (std::size_t v = 0; v < u.size(); ++v) there[v] = u[v] + (sign * step) * direction[v];
    std::vector<Vec3> f(u.size());
    add_elastic_forces(built.model, there, f);
    for (std::size_t v = 0; v < u.size(); ++v) off[v] = off[v] + (0.5 * sign / step) * f[v];
  }
  EXPECT_LT(field_norm(off), 1e-7 * field_norm(exact));
}

TEST(StaticEquilibrium, TheVolumeForceRestores) {
  // A cube under pressure is larger with the force than without when pulled, smaller in neither: the sign of
  // the thesis would blow it up.
  const TetMesh mesh = build_kuhn_cube(3, 0.1, 3);
  BoundaryProblem problem;
  problem.material = {1000.0, 0.25, 1000.0};
  problem.held = rollers(mesh);
  for (int axis = 0; axis < 3; ++axis)
    problem.tractions.push_back({whole(find_faces_at(mesh, axis, 1.0)), {}, -50.0});
  const Loads loads = build_loads(mesh, problem);
  StaticOptions options;
  options.linearised = true;
  const auto swelling = [&](VolumeModel volume, double ratio) {
    SpringModelOptions model_options;
    model_options.volume = volume;
    model_options.volume_force_ratio = ratio;
    const BuiltModel built =
        build_spring_model(mesh, make_edge_springs(mesh, 1000.0), problem.material, model_options);
    TetMesh now = mesh;
    const StaticSolution solution = solve_static(mesh, built.model, loads, options);
    EXPECT_EQ(solution.report.outcome, StaticOutcome::kConverged);
    for (std::size_t v = 0; v < now.points.size(); ++v)
      now.points[v] = now.points[v] + solution.displacement_m[v];
    return total_volume(now) - total_volume(mesh);
  };
  const double alone = swelling(VolumeModel::kNone, 1.0);
  EXPECT_GT(alone, 0.0);
  EXPECT_LT(swelling(VolumeModel::kThesis, 1.0), alone);
  EXPECT_LT(swelling(VolumeModel::kThesis, 10.0), swelling(VolumeModel::kThesis, 1.0));
}

}  // namespace
}  // namespace palpate::dynamics

// Point collocation: derivatives, patch test, quadratic fields, order of convergence, what it refuses.
#include "reference/finite_spheres/collocation.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/error.h"
#include "core/dynamics/linear_algebra/matrix3.h"
#include "core/mesh/shapes/shapes.h"
#include "core/mesh/subdivision/refinement.h"
#include "core/mesh/topology.h"
#include "tests/support/dynamics_cases.h"

namespace palpate::reference {
namespace {

constexpr Material kMaterial{1000.0, 0.3, 1000.0};

std::vector<Index> all_of(const TetMesh& mesh) {
  std::vector<Index> out(mesh.points.size());
  for (Index v = 0; v < out.size(); ++v) out[v] = v;
  return out;
}

CollocationResult solve(const TetMesh& mesh, const BoundaryProblem& problem, double radius = 1.2) {
  return solve_collocation(mesh, problem, build_stencils(mesh, build_spheres(mesh, radius)), all_of(mesh));
}

/// A quadratic polynomial and its derivatives.
double quadratic(const Vec3& x) {
  return 0.3 + 0.7 * x.x - 0.4 * x.y + 1.1 * x.x * x.x - 0.6 * x.y * x.z + 0.8 * x.z * x.z + 0.5 * x.x * x.y;
}

/// The largest error of a stencil's derivatives of the polynomial.
double stencil_error(const TetMesh& mesh, Index v, const DerivativeStencil& stencil) {
  Vec3 first;
  std::array<double, 6> second{};
  for (std::size_t k = 0; k < stencil.neighbours.size(); ++k) {
    const double value = quadratic(mesh.points[stencil.neighbours[k]]);
    first = first + value * stencil.first[k];
    for (std::size_t i = 0; i < 6; ++i) second.at(i) += value * stencil.second[k].at(i);
  }
  const Vec3& x = mesh.points[v];
  const Vec3 wanted{0.7 + 2.2 * x.x + 0.5 * x.y, -0.4 - 0.6 * x.z + 0.5 * x.x, -0.6 * x.y + 1.6 * x.z};
  const std::array<double, 6> curved{2.2, 0.0, 1.6, -0.6, 0.0, 0.5};
  double worst = length(first - wanted);
  for (std::size_t i = 0; i < 6; ++i) worst = std::max(worst, std::abs(second.at(i) - curved.at(i)));
  return worst;
}

TEST(Collocation, StencilsAreExactForQuadraticFields) {
  for (const double radius : {1.05, 1.5}) {
    const TetMesh mesh = build_kuhn_cube(3, 0.2, 7);
    std::vector<DerivativeStencil> stencils = build_stencils(mesh, build_spheres(mesh, radius));
    for (Index v = 0; v < stencils.size(); ++v) EXPECT_LT(stencil_error(mesh, v, stencils[v]), 1e-8) << v;
    stencils[5].second[1][0] *= 1.01;
    EXPECT_GT(stencil_error(mesh, 5, stencils[5]), 1e-4);
  }
}

FacePatch faces_of(const std::vector<Triangle>& faces) {
  return {faces, std::vector<double>(faces.size(), 1.0)};
}

/// Tension along z by tractions on both ends, and elastic supports below that hold what is left.
BoundaryProblem make_tension(const TetMesh& mesh) {
  BoundaryProblem problem;
  problem.material = kMaterial;
  HeldFaces floor;
  floor.faces = testing_support::find_faces_at(mesh, 2, 0.0);
  floor.axes = {false, false, true};
  problem.held.push_back(floor);
  HeldFaces side = floor;
  side.faces = testing_support::find_faces_at(mesh, 0, 0.0);
  side.axes = {true, false, false};
  problem.held.push_back(side);
  HeldFaces front = floor;
  front.faces = testing_support::find_faces_at(mesh, 1, 0.0);
  front.axes = {false, true, false};
  problem.held.push_back(front);
  problem.tractions.push_back(
      {faces_of(testing_support::find_faces_at(mesh, 2, 1.0)), {0.0, 0.0, 50.0}, 0.0});
  return problem;
}

double tension_error(const TetMesh& mesh, const std::vector<Vec3>& u) {
  double worst = 0.0;
  for (std::size_t v = 0; v < u.size(); ++v) {
    const Vec3& x = mesh.points[v];
    worst = std::max(worst, length(u[v] - Vec3{-0.015 * x.x, -0.015 * x.y, 0.05 * x.z}));
  }
  return worst;
}

TEST(Collocation, ABarUnderTensionIsExact) {
  const TetMesh mesh = build_kuhn_cube(3, 0.2, 7);
  BoundaryProblem problem = make_tension(mesh);
  const CollocationResult found = solve(mesh, problem);
  ASSERT_TRUE(found.converged);
  EXPECT_LT(tension_error(mesh, found.displacement_m), 1e-9);
  problem.material.poisson_ratio = 0.31;  // another material's answer is told apart
  EXPECT_GT(tension_error(mesh, solve(mesh, problem).displacement_m), 1e-4);
}

TEST(Collocation, SupportsBalanceATractionThatIsConstant) {
  // Pulled by 50 Pa above, held by springs of 1000 Pa/m below: below it moves by 0.05 m.
  const TetMesh mesh = build_kuhn_cube(3, 0.2, 7);
  BoundaryProblem problem = make_tension(mesh);
  problem.held.erase(problem.held.begin());
  problem.supports.push_back(
      {faces_of(testing_support::find_faces_at(mesh, 2, 0.0)), 1000.0, {0.0, 0.0, 0.02}});
  problem.material.poisson_ratio = 0.0;  // supports resist all axes, and nothing moves across
  const CollocationResult found = solve(mesh, problem);
  double worst = 0.0;
  for (std::size_t v = 0; v < found.displacement_m.size(); ++v)
    worst = std::max(worst, length(found.displacement_m[v] - Vec3{0.0, 0.0, 0.07 + 0.05 * mesh.points[v].z}));
  EXPECT_LT(worst, 1e-9);
}

/// A body whose boundary moves as a field does, with the body force that belongs to it.
template <typename Field, typename Force>
double field_error(const TetMesh& mesh, const Field& field, const Force& force) {
  BoundaryProblem problem;
  problem.material = kMaterial;
  HeldFaces all;
  all.faces = build_boundary(mesh);
  problem.held.push_back(all);
  const std::size_t rows = mesh.points.size() + build_edges(mesh).size();
  problem.held_field_m.resize(rows);
  problem.body_force_n_m3.resize(rows);
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    problem.held_field_m[v] = field(mesh.points[v]);
    problem.body_force_n_m3[v] = force(mesh.points[v]);
  }
  const CollocationResult found = solve(mesh, problem);
  EXPECT_TRUE(found.converged);
  double off = 0.0;
  double size = 0.0;
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    off += length_sq(found.displacement_m[v] - field(mesh.points[v]));
    size += length_sq(field(mesh.points[v]));
  }
  return std::sqrt(off / size);
}

TEST(Collocation, QuadraticFieldsAreExact) {
  const double lambda = kMaterial.lambda_pa();
  const double mu = kMaterial.mu_pa();
  // u = (a x^2, b x y, 0): grad div u = (2a + b, 0, 0), lap u = (2a, 0, 0).
  const auto field = [](const Vec3& x) { return Vec3{0.1 * x.x * x.x, -0.3 * x.x * x.y, 0.0}; };
  const auto force = [&](double share) {
    return [=](const Vec3&) { return Vec3{share * ((lambda + mu) * 0.1 - mu * 0.2), 0.0, 0.0}; };
  };
  const TetMesh mesh = build_kuhn_cube(4, 0.2, 7);
  EXPECT_LT(field_error(mesh, field, force(1.0)), 1e-9);
  EXPECT_GT(field_error(mesh, field, force(1.2)), 1e-5);
}

TEST(Collocation, AWaveIsMetToSecondOrder) {
  const double pi = std::acos(-1.0);
  const double mu = kMaterial.mu_pa();
  // A shear wave: div u = 0, b = mu k^2 u.
  const auto field = [=](const Vec3& x) { return Vec3{0.0, 0.0, std::sin(pi * (x.x + 0.5 * x.y))}; };
  const auto force = [=](const Vec3& x) { return (1.25 * pi * pi * mu) * field(x); };
  const double coarse = field_error(build_kuhn_cube(4, 0.1, 7), field, force);
  const double fine = field_error(build_kuhn_cube(8, 0.1, 7), field, force);
  EXPECT_LT(coarse, 0.05);
  EXPECT_GT(std::log2(coarse / fine), 1.5);
}

TEST(Collocation, AForceInsideIsRefused) {
  const TetMesh mesh = build_kuhn_cube(2, 0.0, 1);
  BoundaryProblem problem = make_tension(mesh);
  problem.nodal_forces.push_back({13, {0.0, 0.0, 1.0}});  // the middle of 3 x 3 x 3
  EXPECT_THROW(solve(mesh, problem), InputError);
}

TEST(Collocation, TooFewVerticesAreRefused) {
  const TetMesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 1, 2, 3}}};
  EXPECT_THROW(build_stencils(mesh, build_spheres(mesh, 1.2)), InputError);
}

}  // namespace
}  // namespace palpate::reference

// fem.p1 and fem.p2 as the runner starts them: closed forms that the shape functions hold exactly, so that
// only rounding and the solver's tolerance are left.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <string>

#include "core/mesh/shapes/shapes.h"
#include "core/mesh/subdivision/refinement.h"
#include "core/mesh/topology.h"
#include "experiments/contestants/contestant_run.h"
#include "reference/closed_form/solutions.h"
#include "reference/door/deform_problem.h"
#include "tests/support/finite_elements.h"
#include "tests/support/scratch_folder.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;

using namespace test;  // NOLINT(google-build-using-namespace)

const std::vector<std::string> kElements{"fem.p1", "fem.p2"};

TEST_F(FiniteElements, PassThePatchTest) {
  const TetMesh mesh = irregular_cube();
  const Field linear = [](const Vec3& p) {
    return Vec3{1e-2 + 0.2 * p.x - 0.1 * p.y + 0.3 * p.z, 0.15 * p.x + 0.1 * p.y, -0.2 * p.z + 0.25 * p.y};
  };
  const std::vector<Vec3> wanted = at_nodes(mesh, linear);
  BoundaryProblem problem;
  problem.material = {10000.0, 0.45, 1050.0};
  problem.held.push_back({faces_where(mesh, is_everywhere), {true, true, true}, {}});
  problem.held_field_m = wanted;
  for (const std::string& method : kElements) {
    for (const StrainSize strain : {StrainSize::kSmall, StrainSize::kLarge}) {
      for (const char* solver : {"mumps", "gamg"}) {
        problem.strain = strain;
        const auto found = solve(method, mesh, problem, {{"solver", solver}, {"rtol", 1e-12}});
        EXPECT_LT(difference(found, wanted), 1e-10)
            << method << ' ' << solver << (strain == StrainSize::kSmall ? " small" : " large");
      }
    }
  }
  std::vector<Vec3> broken = wanted;  // the order is part of the answer
  std::swap(broken[10], broken[11]);
  EXPECT_GT(difference(broken, wanted), 1e-3);
}

TEST_F(FiniteElements, BarInTensionIsExact) {
  const TetMesh mesh = build_bar(1);
  BoundaryProblem problem;
  problem.material = {10000.0, 0.3, 1050.0};
  hold_planes(mesh, problem);
  pull(
      mesh, [](const Vec3& p) { return p.x == 4.0; }, {500.0, 0.0, 0.0}, problem);
  const double strain = 500.0 / 10000.0;
  const auto wanted = at_nodes(mesh, [&](const Vec3& p) {
    return strain * Vec3{p.x, -0.3 * p.y, -0.3 * p.z};
  });
  for (const std::string& method : kElements) {
    EXPECT_LT(difference(solve(method, mesh, problem), wanted), 1e-9) << method;
    EXPECT_NEAR(report_.at("energy_j").get<double>(), 0.5 * 500.0 * strain * 4.0, 1e-6) << method;
    EXPECT_LE(report_.at("residual_relative").get<double>(), 1e-10) << method;
  }
}

TEST_F(FiniteElements, PressureActsAgainstTheOutwardNormal) {
  const TetMesh mesh = irregular_cube();
  BoundaryProblem problem;
  problem.material = {10000.0, 0.3, 1050.0};
  hold_planes(mesh, problem);
  for (const auto axis : {&Vec3::x, &Vec3::y, &Vec3::z})
    problem.tractions.push_back(
        {patch_where(mesh, [&](const Vec3& p) { return p.*axis == 1.0; }), {}, 200.0});
  const double strain = -200.0 * (1.0 - 2.0 * 0.3) / 10000.0;
  const auto wanted = at_nodes(mesh, [&](const Vec3& p) { return strain * p; });
  for (const std::string& method : kElements)
    EXPECT_LT(difference(solve(method, mesh, problem), wanted), 1e-9) << method;
}

TEST_F(FiniteElements, QuadraticShapesHoldAHangingBarExactly) {
  const TetMesh mesh = build_bar(1);
  BoundaryProblem problem;
  problem.material = {10000.0, 0.0, 1000.0};
  problem.gravity_m_s2 = {9.81, 0.0, 0.0};
  problem.held.push_back({faces_where(mesh, is_at_x0), {true, true, true}, {}});
  const double weight = 1000.0 * 9.81 / 10000.0;
  const auto wanted = at_nodes(mesh, [&](const Vec3& p) {
    return Vec3{weight * (4.0 * p.x - 0.5 * p.x * p.x), 0.0, 0.0};
  });
  EXPECT_LT(difference(solve("fem.p2", mesh, problem), wanted), 1e-9);
  EXPECT_GT(difference(solve("fem.p1", mesh, problem), wanted), 1e-3);  // linear shapes cannot

  problem.gravity_m_s2 = {};  // the same weight as a field
  problem.body_force_n_m3 = at_nodes(mesh, [](const Vec3&) { return Vec3{9810.0, 0.0, 0.0}; });
  EXPECT_LT(difference(solve("fem.p2", mesh, problem), wanted), 1e-9);
}

TEST_F(FiniteElements, ElasticSupportIsASpringBedBelowTheBar) {
  const TetMesh mesh = build_bar(1);
  BoundaryProblem problem;
  problem.material = {10000.0, 0.0, 1050.0};
  const double stiffness = 4000.0;
  problem.supports.push_back({patch_where(mesh, is_at_x0, 0.5), stiffness, {0.01, 0.02, 0.0}});
  pull(
      mesh, [](const Vec3& p) { return p.x == 4.0; }, {300.0, 0.0, 0.0}, problem);
  const auto wanted = at_nodes(mesh, [&](const Vec3& p) {
    return Vec3{0.01 + 300.0 / (0.5 * stiffness) + 300.0 / 10000.0 * p.x, 0.02, 0.0};
  });
  for (const std::string& method : kElements) {
    EXPECT_LT(difference(solve(method, mesh, problem), wanted), 1e-9) << method;
    EXPECT_NEAR(report_.at("support_energy_j").get<double>(), 0.5 * 300.0 * 300.0 / (0.5 * stiffness), 1e-6);
    EXPECT_NEAR(report_.at("energy_j").get<double>(), 0.5 * 300.0 * 300.0 / 10000.0 * 4.0, 1e-6) << method;
  }
}

TEST_F(FiniteElements, StiffBlockTiltsOnItsSpringBedAsItsSecondMomentSays) {
  const TetMesh mesh = irregular_cube();
  BoundaryProblem problem;
  problem.material = {1e9, 0.3, 1050.0};
  const double stiffness = 1000.0;
  problem.supports.push_back({patch_where(mesh, [](const Vec3& p) { return p.z == 0.0; }), stiffness, {}});
  const auto corner = [&](double x) {
    return static_cast<Index>(std::find(mesh.points.begin(), mesh.points.end(), Vec3{x, 0.0, 1.0}) -
                              mesh.points.begin());
  };
  // A couple about y: up at x = 0, down at x = 1. The second moment of the unit square about its middle is
  // 1 / 12, which a lumped mass would miss.
  problem.nodal_forces = {{corner(0.0), {0.0, 0.0, 0.5}}, {corner(1.0), {0.0, 0.0, -0.5}}};
  const double tilt = 0.5 / (stiffness / 12.0);
  for (const std::string& method : kElements) {
    const auto found = solve(method, mesh, problem);
    ASSERT_FALSE(found.empty());
    double most = 0.0;
    for (std::size_t v = 0; v < mesh.points.size(); ++v)
      most = std::max(most, std::fabs(found[v].z - tilt * (0.5 - mesh.points[v].x)));
    EXPECT_LT(most, 1e-4 * tilt) << method;  // the block itself gives in by about stiffness / modulus
  }
}

TEST_F(FiniteElements, NeoHookeanBarStretchesAsItsClosedFormSays) {
  const TetMesh mesh = build_bar(1);
  for (const double poisson : {0.3, 0.49}) {
    for (const double along : {1.3, 0.7}) {
      BoundaryProblem problem;
      problem.material = {10000.0, poisson, 1050.0};
      problem.strain = StrainSize::kLarge;
      hold_planes(mesh, problem);
      const reference::UniaxialStretch s = reference::stretch_neo_hookean(problem.material, along);
      pull(
          mesh, [](const Vec3& p) { return p.x == 4.0; }, {s.traction_pa, 0.0, 0.0}, problem);
      const auto wanted = at_nodes(mesh, [&](const Vec3& p) {
        return Vec3{(along - 1.0) * p.x, (s.across - 1.0) * p.y, (s.across - 1.0) * p.z};
      });
      for (const std::string& method : kElements)
        EXPECT_LT(difference(solve(method, mesh, problem), wanted), 1e-8)
            << method << ' ' << poisson << ' ' << along;
    }
  }
}

TEST_F(FiniteElements, NeoHookeanTendsToLinearElasticity) {
  const TetMesh mesh = irregular_cube();
  for (const std::string& method : kElements) {
    double last = 0.0;
    for (const double scale : {1e-2, 1e-3}) {
      BoundaryProblem problem = supported_cube(mesh, scale);
      const auto small = solve(method, mesh, problem);
      problem.strain = StrainSize::kLarge;
      const double now = difference(solve(method, mesh, problem), small);
      EXPECT_GT(now, 1e-7) << method;
      if (last > 0.0) {
        EXPECT_NEAR(last / now, 10.0, 0.5) << method;  // of first order in the load
      }
      last = now;
    }
  }
}

}  // namespace
}  // namespace palpate::experiments

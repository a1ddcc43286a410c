// fem.p1 and fem.p2 as the runner starts them: closed forms that the shape functions hold exactly, so that
// only rounding and the solver's tolerance are left.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <string>

#include "core/mesh/refinement.h"
#include "core/mesh/shapes/shapes.h"
#include "core/mesh/topology.h"
#include "experiments/contestants/contestant_run.h"
#include "reference/closed_form/solutions.h"
#include "reference/door/deform_problem.h"
#include "tests/support/contestant_starter.h"
#include "tests/support/scratch_folder.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;
using testing::HasSubstr;

using Field = std::function<Vec3(const Vec3&)>;

/// Starts a method on a problem.
class FiniteElements : public testing::Test {
 protected:
  void SetUp() override { ASSERT_EQ(starter_.registry().find("fem.p2")->contestant->unavailable(), ""); }

  ContestantAnswer run(const std::string& method, const TetMesh& mesh, const BoundaryProblem& problem,
                       const json& options = json::object()) {
    return starter_.run(method, mesh, reference::problem_to_json(problem), options);
  }

  /// The displacement that it answers: vertices, then edge midpoints.
  std::vector<Vec3> solve(const std::string& method, const TetMesh& mesh, const BoundaryProblem& problem,
                          const json& options = json::object()) {
    const ContestantAnswer answer = run(method, mesh, problem, options);
    EXPECT_EQ(answer.outcome, "ok") << answer.message;
    if (answer.outcome != "ok") return {};
    report_ = answer.report;
    EXPECT_EQ(report_.at("outcome"), "converged");
    const std::size_t edges = build_edges(mesh).size();
    return reference::read_displacement(answer.output, mesh.points.size(), edges);
  }

  test::ContestantStarter starter_;
  json report_;
};

const std::vector<std::string> kMethods{"fem.p1", "fem.p2"};

/// A field at the vertices and edge midpoints of a mesh.
std::vector<Vec3> at_nodes(const TetMesh& mesh, const Field& field) {
  std::vector<Vec3> values;
  for (const Vec3& point : mesh.points) values.push_back(field(point));
  for (const Edge& edge : build_edges(mesh))
    values.push_back(field(0.5 * (mesh.points[edge[0]] + mesh.points[edge[1]])));
  return values;
}

/// The largest difference over the largest length of `wanted`; infinite if the sizes differ.
double difference(const std::vector<Vec3>& found, const std::vector<Vec3>& wanted) {
  if (found.size() != wanted.size()) return INFINITY;
  double most = 0.0;
  double scale = 0.0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    most = std::max(most, length(found[i] - wanted[i]));
    scale = std::max(scale, length(wanted[i]));
  }
  return most / scale;
}

/// Boundary faces whose corners all have `is_in`.
std::vector<Triangle> faces_where(const TetMesh& mesh, const std::function<bool(const Vec3&)>& is_in) {
  std::vector<Triangle> faces;
  for (const Triangle& face : build_boundary(mesh)) {
    if (std::all_of(face.begin(), face.end(), [&](Index v) { return is_in(mesh.points[v]); }))
      faces.push_back(face);
  }
  return faces;
}

FacePatch patch_where(const TetMesh& mesh, const std::function<bool(const Vec3&)>& is_in,
                      double weight = 1.0) {
  FacePatch patch{faces_where(mesh, is_in), {}};
  patch.weight.assign(patch.faces.size(), weight);
  return patch;
}

bool is_everywhere(const Vec3&) {
  return true;
}
bool is_at_x0(const Vec3& p) {
  return p.x == 0.0;
}

/// The unit cube with its inner vertices moved at random.
TetMesh irregular_cube() {
  return build_kuhn_cube(3, 0.4, 11);
}

/// Each of the planes x = 0, y = 0, z = 0 keeps to itself: a body may stretch along the axes, and nothing
/// else.
void hold_planes(const TetMesh& mesh, BoundaryProblem& problem) {
  problem.held.push_back({faces_where(mesh, is_at_x0), {true, false, false}, {}});
  problem.held.push_back(
      {faces_where(mesh, [](const Vec3& p) { return p.y == 0.0; }), {false, true, false}, {}});
  problem.held.push_back(
      {faces_where(mesh, [](const Vec3& p) { return p.z == 0.0; }), {false, false, true}, {}});
}

/// A force a unit of area on the faces where `is_in`.
void pull(const TetMesh& mesh, const std::function<bool(const Vec3&)>& is_in, const Vec3& traction_pa,
          BoundaryProblem& problem) {
  problem.tractions.push_back({patch_where(mesh, is_in), traction_pa, 0.0});
}

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
  for (const std::string& method : kMethods) {
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
  for (const std::string& method : kMethods) {
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
  for (const std::string& method : kMethods)
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
  for (const std::string& method : kMethods) {
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
  for (const std::string& method : kMethods) {
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
      for (const std::string& method : kMethods)
        EXPECT_LT(difference(solve(method, mesh, problem), wanted), 1e-8)
            << method << ' ' << poisson << ' ' << along;
    }
  }
}

/// A cube on a spring bed, pulled aside and pressed at one face by a pad.
BoundaryProblem supported_cube(const TetMesh& mesh, double scale) {
  BoundaryProblem problem;
  problem.material = {10000.0, 0.45, 1050.0};
  problem.supports.push_back({patch_where(
                                  mesh, [](const Vec3& p) { return p.z == 0.0; }, 0.7),
                              1e5,
                              {}});
  problem.supports.push_back(
      {patch_where(mesh, [](const Vec3& p) { return p.x == 1.0; }), 5e4, scale * Vec3{-0.1, 0.05, 0.0}});
  pull(
      mesh, [](const Vec3& p) { return p.y == 1.0; }, scale * Vec3{200.0, 0.0, -100.0}, problem);
  return problem;
}

TEST_F(FiniteElements, NeoHookeanTendsToLinearElasticity) {
  const TetMesh mesh = irregular_cube();
  for (const std::string& method : kMethods) {
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

TEST_F(FiniteElements, TwoProcessesGiveTheSameAnswer) {
  const TetMesh mesh = irregular_cube();
  BoundaryProblem problem = supported_cube(mesh, 1.0);
  problem.held.push_back(
      {faces_where(mesh, [](const Vec3& p) { return p.y == 0.0; }), {false, true, false}, {0.0, 0.01, 0.0}});
  problem.nodal_forces = {{0, {1.0, 2.0, 3.0}}};
  problem.strain = StrainSize::kLarge;
  for (const std::string& method : kMethods) {
    for (const char* solver : {"mumps", "gamg"}) {
      const auto one = solve(method, mesh, problem, {{"solver", solver}, {"processes", 1}});
      EXPECT_EQ(report_.at("processes"), 1);
      const auto two = solve(method, mesh, problem, {{"solver", solver}, {"processes", 2}});
      EXPECT_EQ(report_.at("processes"), 2);
      EXPECT_LT(difference(two, one), 1e-8) << method << ' ' << solver;
    }
  }
}

TEST_F(FiniteElements, SameRequestSameBytes) {
  const TetMesh mesh = irregular_cube();
  const BoundaryProblem problem = supported_cube(mesh, 1.0);
  const json options{{"solver", "gamg"}, {"refine", 1}};
  const auto first = run("fem.p2", mesh, problem, options);
  const auto second = run("fem.p2", mesh, problem, options);
  ASSERT_EQ(first.outcome, "ok") << first.message;
  EXPECT_EQ(test::bytes_of(first.output), test::bytes_of(second.output));
}

TEST_F(FiniteElements, RefinedAnswerIsThatOfTheRefinedMeshAtTheBaseMeshsNodes) {
  const TetMesh mesh = build_kuhn_cube(2, 0.3, 4);
  BoundaryProblem problem = supported_cube(mesh, 1.0);
  problem.held.push_back({faces_where(mesh, is_at_x0), {false, false, true}, {0.0, 0.0, 0.02}});
  const TetMesh refined = refine_uniformly(mesh);
  const BoundaryProblem refined_problem = refine_problem(problem, mesh, refined);
  for (const std::string& method : kMethods) {
    const auto found = solve(method, mesh, problem, {{"refine", 1}, {"rtol", 1e-12}});
    EXPECT_EQ(found.size(), refined.points.size());
    auto wanted = solve(method, refined, refined_problem, {{"rtol", 1e-12}});
    wanted.resize(refined.points.size());
    EXPECT_LT(difference(found, wanted), 1e-9) << method;
  }
}

// With nothing but a pad that moves, the least of all energies is half of by . F, and a finer mesh, whose
// fields hold the coarser one's, can only lower it. Supports and pad balance each other.
TEST_F(FiniteElements, ThePadsForceIsTwiceTheLeastEnergyOverItsWayAndFallsWhenRefined) {
  const TetMesh mesh = build_kuhn_cube(2, 0.3, 4);
  BoundaryProblem problem = supported_cube(mesh, 1.0);
  problem.tractions.clear();
  problem.gravity_m_s2 = {};
  for (const std::string& method : kMethods) {
    double coarser = INFINITY;
    for (const int refine : {0, 1}) {
      solve(method, mesh, problem, {{"refine", refine}, {"rtol", 1e-12}});
      std::vector<Vec3> forces;
      for (const json& force : report_.at("support_forces_n"))
        forces.push_back({force.at(0).get<double>(), force.at(1).get<double>(), force.at(2).get<double>()});
      ASSERT_EQ(forces.size(), 2U);
      const double work = dot(problem.supports[1].by_m, forces[1]);
      const double energy =
          report_.at("energy_j").get<double>() + report_.at("support_energy_j").get<double>();
      EXPECT_NEAR(work, 2.0 * energy, 1e-9 * energy) << method << ' ' << refine;
      EXPECT_LE(length(forces[0] + forces[1]), 1e-9 * length(forces[1])) << method;
      EXPECT_LT(work, coarser) << method;
      coarser = work;
    }
  }
}

TEST_F(FiniteElements, FurtherLoadsOfOneBodyAreSolvedWithTheSameFactors) {
  const TetMesh mesh = irregular_cube();
  const BoundaryProblem problem = supported_cube(mesh, 1.0);
  BoundaryProblem pushed = problem;
  pushed.supports[1].by_m = {0.0, 0.0, 0.02};
  pushed.tractions.clear();
  pushed.nodal_forces = {{3, {1.0, -2.0, 0.5}}};
  BoundaryProblem stiffer = problem;
  stiffer.supports[0].stiffness_pa_per_m *= 2.0;
  const test::ScratchFolder folder;
  const auto list = [&](const BoundaryProblem& further) {
    const auto file = folder.add("further.json.problem", reference::problem_to_json(further).dump());
    return folder.add("further.json", json::array({{{"problem_in", file.string()},
                                                    {"displacement_out", (folder / "further.csv").string()}}})
                                          .dump());
  };
  for (const std::string& method : kMethods) {
    for (const char* solver : {"mumps", "gamg"}) {
      const auto alone = solve(method, mesh, pushed, {{"solver", solver}, {"rtol", 1e-12}});
      const auto first = solve(method, mesh, problem, {{"solver", solver}, {"rtol", 1e-12}});
      const json options = {{"solver", solver}, {"rtol", 1e-12}, {"further", list(pushed).string()}};
      EXPECT_LE(difference(solve(method, mesh, problem, options), first), 1e-10);
      ASSERT_EQ(report_.at("further").size(), 1U);
      EXPECT_EQ(report_.at("further").at(0).at("outcome"), "converged");
      const auto along =
          reference::read_displacement(folder / "further.csv", mesh.points.size(), build_edges(mesh).size());
      EXPECT_LE(difference(along, alone), 1e-9) << method << ' ' << solver;
    }
  }
  const ContestantAnswer refused = run("fem.p2", mesh, problem, {{"further", list(stiffer).string()}});
  EXPECT_EQ(refused.outcome, "bad_input");
  EXPECT_THAT(refused.message, HasSubstr("another stiffness"));
}

TEST_F(FiniteElements, WhatCannotBeSolvedIsAnOutcome) {
  const TetMesh mesh = build_kuhn_cube(2, 0.0, 1);
  BoundaryProblem problem;
  problem.material = {10000.0, 0.3, 1050.0};
  problem.strain = StrainSize::kLarge;
  problem.held.push_back({faces_where(mesh, is_at_x0), {true, true, true}, {}});
  problem.held.push_back(  // through the opposite side
      {faces_where(mesh, [](const Vec3& p) { return p.x == 1.0; }), {true, true, true}, {-1.5, 0.0, 0.0}});
  const ContestantAnswer answer = run("fem.p1", mesh, problem);
  EXPECT_EQ(answer.outcome, "ok") << answer.message;
  EXPECT_EQ(answer.report.at("outcome"), "not_converged");
  EXPECT_TRUE(answer.output.empty() || !std::filesystem::exists(answer.output));
}

TEST_F(FiniteElements, FreeRigidMotionsAreRefused) {
  const TetMesh mesh = build_kuhn_cube(2, 0.0, 1);
  BoundaryProblem problem;
  problem.material = {10000.0, 0.3, 1050.0};
  problem.gravity_m_s2 = {0.0, 0.0, -9.81};
  const ContestantAnswer nothing = run("fem.p2", mesh, problem);
  EXPECT_EQ(nothing.outcome, "bad_input");
  EXPECT_THAT(nothing.message, HasSubstr("6 motions left free"));
  problem.held.push_back({faces_where(mesh, is_at_x0), {true, false, false}, {}});
  EXPECT_THAT(run("fem.p1", mesh, problem).message,
              HasSubstr("3 motions left free"));  // slides, spins about x
  hold_planes(mesh, problem);
  EXPECT_EQ(run("fem.p1", mesh, problem).outcome, "ok");
}

TEST_F(FiniteElements, BadRequestsAreRefusedInOneLine) {
  const TetMesh mesh = build_kuhn_cube(2, 0.0, 1);
  const BoundaryProblem problem = supported_cube(mesh, 1.0);
  const auto refusal = [&](const BoundaryProblem& asked, const json& options) {
    const ContestantAnswer answer = run("fem.p2", mesh, asked, options);
    EXPECT_EQ(answer.outcome, "bad_input");
    EXPECT_EQ(answer.message.find('\n'), std::string::npos);
    return answer.message;
  };
  EXPECT_THAT(refusal(problem, {{"levels", 1}}), HasSubstr("levels"));
  EXPECT_THAT(refusal(problem, {{"refine", 9}}), HasSubstr("refine"));
  EXPECT_THAT(refusal(problem, {{"solver", "lu"}, {"processes", 2}}), HasSubstr("solver"));
  BoundaryProblem broken = problem;
  broken.material.poisson_ratio = 0.5;
  EXPECT_THAT(refusal(broken, json::object()), HasSubstr("poisson_ratio"));
}

}  // namespace
}  // namespace palpate::experiments

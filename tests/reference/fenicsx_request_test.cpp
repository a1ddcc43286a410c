// fem.p1 and fem.p2 as the runner starts them: what their requests may ask for, and how they end.
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
using testing::HasSubstr;

using namespace test;  // NOLINT(google-build-using-namespace)

const std::vector<std::string> kMethods{"fem.p1", "fem.p2"};

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

TEST_F(FiniteElements, TheCostOfAFurtherAnswerIsAskedForAndChangesNothing) {
  const TetMesh mesh = irregular_cube();
  BoundaryProblem problem = supported_cube(mesh, 1.0);
  for (const std::string& method : kMethods) {
    for (const char* solver : {"mumps", "gamg"}) {
      const auto plain = solve(method, mesh, problem, {{"solver", solver}});
      EXPECT_FALSE(report_.contains("answer_s"));
      EXPECT_EQ(difference(solve(method, mesh, problem, {{"solver", solver}, {"cost", true}}), plain), 0.0);
      EXPECT_GT(report_.at("answer_s").get<double>(), 0.0);
    }
  }
  problem.strain = StrainSize::kLarge;
  const auto refused = run("fem.p1", mesh, problem, {{"cost", true}});
  EXPECT_EQ(refused.outcome, "bad_input");
  EXPECT_THAT(refused.message, HasSubstr("one linear system"));
}

}  // namespace
}  // namespace palpate::experiments

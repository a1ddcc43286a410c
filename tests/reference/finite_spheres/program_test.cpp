// finite_spheres as the runner starts it: good bodies, bad options, and what it refuses.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "core/judge/displacement/displacement.h"
#include "core/mesh/shapes/shapes.h"
#include "core/mesh/topology.h"
#include "experiments/contestants/contestant_run.h"
#include "reference/closed_form/known_cases.h"
#include "reference/closed_form/solutions.h"
#include "reference/door/deform_problem.h"
#include "reference/finite_spheres/sphere_system.h"
#include "tests/support/contestant_starter.h"

namespace palpate::reference {
namespace {

using experiments::ContestantAnswer;
using nlohmann::json;
using testing::HasSubstr;

class FiniteSpheres : public testing::Test {
 protected:
  ContestantAnswer ask(const KnownCase& known, const json& options = json::object()) {
    return starter_.run("finite_spheres", known.mesh, problem_to_json(known.problem), options);
  }

  std::vector<Vec3> displacement(const KnownCase& known, const ContestantAnswer& answer) {
    EXPECT_EQ(answer.outcome, "ok") << answer.message;
    if (answer.outcome != "ok") return {};
    EXPECT_EQ(answer.report.at("outcome"), "converged");
    return read_displacement(answer.output, known.mesh.points.size(), build_edges(known.mesh).size());
  }

  /// The judge's relative L2 error.
  static double judged(const KnownCase& known, const std::vector<Vec3>& u) {
    std::vector<Vec3> truth;
    for (const Vec3& x : known.mesh.points) truth.push_back(known.displacement(x));
    const Material& material = known.problem.material;
    return judge::compare_displacement(known.mesh, u, truth, material.lambda_pa(), material.mu_pa())
        .relative_l2;
  }

  test::ContestantStarter starter_;
};

TEST_F(FiniteSpheres, AnswersAKnownCaseToRounding) {
  const KnownCase known = build_known_case("bar_tension", 2);
  const ContestantAnswer answer = ask(known, {{"integration", "nodal"}, {"rtol", 1e-13}});
  const std::vector<Vec3> u = displacement(known, answer);
  ASSERT_EQ(u.size(), known.mesh.points.size());
  EXPECT_LT(judged(known, u), 1e-8);
  // The energy of a bar: half its force times its lengthening.
  const double stress = 250.0;
  const double energy = 0.5 * stress * stress / 10000.0 * 0.04 * 0.01 * 0.01;
  EXPECT_NEAR(answer.report.at("energy_j").get<double>(), energy, 1e-7 * energy);
  EXPECT_NEAR(answer.report.at("potential_j").get<double>(), -energy, 1e-7 * energy);
  EXPECT_LT(answer.report.at("held_error_m").get<double>(), 1e-9);
  for (const char* key : {"assembly_s", "solve_s", "matrix_bytes", "unknowns", "points"})
    EXPECT_GT(answer.report.at(key).get<double>(), 0.0) << key;
}

TEST_F(FiniteSpheres, TheJudgeRejectsCoefficientsInPlaceOfTheField) {
  // The functions don't interpolate: coefficients differ from displacements by something like r^2 u''.
  const KnownCase known = build_known_case("bar_own_weight", 2);
  const std::vector<Vec3> u = displacement(known, ask(known, {{"points", 14}, {"radius", 1.3}}));
  ASSERT_EQ(u.size(), known.mesh.points.size());
  const IntegrationOptions points{SphereIntegration::kGauss, 14, 0};
  const SphereField field = build_sphere_field(known.mesh, 1.3, SphereFunctions::kLeastSquares);
  SphereSystem system = build_body_system(field, known.problem, points);
  add_boundary(field, known.problem, points, 100.0, system);
  const SphereSolution found = solve_spheres(system, {});
  ASSERT_TRUE(found.converged);
  const double good = judged(known, u);
  RecordProperty("own_weight_error", std::to_string(good));
  EXPECT_NEAR(judged(known, sample_displacement(field, found.coefficients_m, false)), good, 1e-6);
  EXPECT_GT(judged(known, found.coefficients_m), 2.0 * good);
}

TEST_F(FiniteSpheres, HasTheDeflectionOfACantilever) {
  double before = 1.0;
  for (const int cells : {2, 4}) {
    const KnownCase known = build_known_case("cantilever", cells);
    const std::vector<Vec3> u = displacement(known, ask(known));
    ASSERT_EQ(u.size(), known.mesh.points.size());
    const double error = std::fabs(u[known.value->vertex].z / known.value->value - 1.0);
    RecordProperty("cantilever_" + std::to_string(cells), std::to_string(error));
    EXPECT_LT(error, before);
    before = error;
  }
  EXPECT_LT(before, 0.01);  // what a beam's theory leaves out: the square of thickness over length
}

TEST_F(FiniteSpheres, WritesMidpointsWhenAsked) {
  const KnownCase known = build_known_case("bar_pads", 2);
  const std::size_t vertices = known.mesh.points.size();
  const std::vector<Vec3> with = displacement(known, ask(known, {{"midpoints", true}}));
  EXPECT_EQ(with.size(), vertices + build_edges(known.mesh).size());
  EXPECT_EQ(displacement(known, ask(known)).size(), vertices);
}

TEST_F(FiniteSpheres, RefusesWhatItCannotDo) {
  KnownCase known = build_known_case("bar_tension", 2);
  const auto refused = [&](const json& options) {
    const ContestantAnswer answer = ask(known, options);
    EXPECT_EQ(answer.outcome, "bad_input") << options;
    return answer.message;
  };
  EXPECT_THAT(refused({{"points", 11}}), HasSubstr("1, 4 or 14"));
  EXPECT_THAT(refused({{"functions", "splines"}}), HasSubstr("mls or shepard"));
  EXPECT_THAT(refused({{"radius", 0.9}}), HasSubstr("radius"));
  EXPECT_THAT(refused({{"functions", "shepard"}, {"integration", "nodal"}}), HasSubstr("gauss for"));
  EXPECT_THAT(refused({{"spheres", 3}}), HasSubstr("spheres"));
  known.problem.tractions.clear();
  EXPECT_THAT(refused({{"local_radius_m", 0.01}}), HasSubstr("local_radius_m"));
  known.problem.held.clear();
  EXPECT_THAT(refused(json::object()), HasSubstr("translation"));
  known.problem.strain = StrainSize::kLarge;
  EXPECT_THAT(refused(json::object()), HasSubstr("small: finite_spheres is linear"));
}

TEST_F(FiniteSpheres, CollocationAnswersAKnownCaseAndRefusesWhatItCannotDo) {
  KnownCase known = build_known_case("bar_tension", 3);
  const auto collocate = [&](const json& options) {
    return starter_.run("finite_spheres.collocation", known.mesh, problem_to_json(known.problem), options);
  };
  const ContestantAnswer answer = collocate(json::object());
  const std::vector<Vec3> u = displacement(known, answer);
  ASSERT_EQ(u.size(), known.mesh.points.size());
  EXPECT_LT(judged(known, u), 1e-8);
  EXPECT_LT(answer.report.at("residual_relative").get<double>(), 1e-8);
  EXPECT_EQ(collocate({{"points", 4}}).outcome, "bad_input");  // of the other form
  EXPECT_EQ(collocate({{"radius", 0.9}}).outcome, "bad_input");
  known.problem.strain = StrainSize::kLarge;
  EXPECT_THAT(collocate(json::object()).message, HasSubstr("collocation is linear"));
}

TEST_F(FiniteSpheres, CollocationThatLosesItsBalanceIsNotGiven) {
  // A jittered cube on a bed, pressed by a pad on half of its top; nothing holds it hard.
  const TetMesh mesh = build_kuhn_cube(6, 0.3, 6);
  BoundaryProblem problem;
  problem.material = {1e4, 0.45, 1000.0};
  problem.supports = {{{}, 1e5, {}}, {{}, 1e6, {0.0, 0.0, -0.01}}};
  for (const Triangle& face : build_boundary(mesh)) {
    const Vec3 middle = (1.0 / 3.0) * (mesh.points[face[0]] + mesh.points[face[1]] + mesh.points[face[2]]);
    const bool is_bed = middle.z < 1e-9;
    if (!is_bed && !(middle.z > 1.0 - 1e-9 && middle.x < 0.5)) continue;
    FacePatch& patch = problem.supports[is_bed ? 0 : 1].patch;
    patch.faces.push_back(face);
    patch.weight.push_back(1.0);
  }
  const auto collocate = [&](double poisson_ratio, double radius) {
    problem.material.poisson_ratio = poisson_ratio;
    return starter_.run("finite_spheres.collocation", mesh, problem_to_json(problem), {{"radius", radius}});
  };
  const ContestantAnswer lost = collocate(0.49, 1.2);
  EXPECT_EQ(lost.report.at("outcome"), "not_converged");
  EXPECT_GT(lost.report.at("net_force_share").get<double>(), 0.3);
  EXPECT_FALSE(std::filesystem::exists(lost.output));
  ASSERT_EQ(lost.notes.size(), 1U);
  EXPECT_THAT(lost.notes[0], HasSubstr("worthless and not given"));
  const ContestantAnswer doubtful = collocate(0.45, 1.5);
  EXPECT_EQ(doubtful.report.at("outcome"), "converged");
  EXPECT_GT(doubtful.report.at("net_force_share").get<double>(), 0.05);
  ASSERT_EQ(doubtful.notes.size(), 1U);
  EXPECT_THAT(doubtful.notes[0], HasSubstr("out of balance: the answer may be far off"));
  const ContestantAnswer good = collocate(0.25, 1.5);
  EXPECT_EQ(good.report.at("outcome"), "converged");
  EXPECT_LT(good.report.at("net_force_share").get<double>(), 0.05);
  EXPECT_TRUE(good.notes.empty());
}

TEST_F(FiniteSpheres, SaysThatAProblemIsBroken) {
  const KnownCase known = build_known_case("bar_tension", 2);
  json problem = problem_to_json(known.problem);
  problem["material"]["poisson_ratio"] = 0.7;
  const ContestantAnswer answer = starter_.run("finite_spheres", known.mesh, problem);
  EXPECT_EQ(answer.outcome, "bad_input");
  EXPECT_THAT(answer.message, HasSubstr("poisson_ratio"));
}

TEST_F(FiniteSpheres, RunningOutOfIterationsLeavesNoDisplacement) {
  const KnownCase known = build_known_case("bar_pads", 2);
  const ContestantAnswer answer = ask(known, {{"solver", "cg"}, {"iterations", 2}});
  EXPECT_EQ(answer.outcome, "ok") << answer.message;
  EXPECT_EQ(answer.report.at("outcome"), "not_converged");
  EXPECT_FALSE(std::filesystem::exists(answer.output));
}

TEST_F(FiniteSpheres, TheSameRequestGivesTheSameBytes) {
  const KnownCase known = build_known_case("bar_pads", 2);
  const auto bytes = [&] {
    std::ifstream file(ask(known).output);
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  const std::string first = bytes();
  EXPECT_FALSE(first.empty());
  EXPECT_EQ(first, bytes());
}

}  // namespace
}  // namespace palpate::reference

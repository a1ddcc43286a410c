// fem.p2_patch, fem.p2_coarse, fem.p1_modes and graded.edge_node as the runner starts them: known answers,
// the elements at their limits, nested spaces, and what they refuse.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/mesh/shapes/shapes.h"
#include "reference/door/json_file.h"
#include "tests/support/finite_elements.h"

namespace palpate::test {
namespace {

using experiments::ContestantAnswer;
using nlohmann::json;
using testing::HasSubstr;

/// Few samples, so that learning takes a moment.
json few_samples() {
  return {{"samples", 12}, {"modes", 8}, {"validate", 4}};
}

/// What a method is asked with where it does not matter.
json quick_options(const std::string& method) {
  return method == "fem.p1_modes" ? few_samples() : json::object();
}

class MixedOrder : public FiniteElements {
 protected:
  static const std::vector<std::string>& methods() {
    static const std::vector<std::string> all{"fem.p2_patch", "fem.p2_coarse", "fem.p1_modes",
                                              "graded.edge_node"};
    return all;
  }

  std::vector<Vec3> at_vertices(const std::string& method, const json& options) {
    std::vector<Vec3> rows = solve(method, mesh_, problem_, options);
    rows.resize(mesh_.points.size());
    return rows;
  }
  double potential(const std::string& method, const json& options) {
    solve(method, mesh_, problem_, options);
    return report_.at("potential_j").get<double>();
  }

  TetMesh mesh_ = build_kuhn_cube(5, 0.3, 6);
  BoundaryProblem problem_ = supported_cube(mesh_, 0.01);
};

TEST_F(MixedOrder, APatchInTensionIsExact) {
  // u = s / E (x, -nu y, -nu z) under a tension s: linear, so every method has it.
  const double strain = 0.01;
  problem_ = {};
  problem_.material = {1e4, 0.3, 1000.0};
  hold_planes(mesh_, problem_);
  pull(
      mesh_, [](const Vec3& p) { return p.x == 1.0; }, {1e4 * strain, 0.0, 0.0}, problem_);
  const auto wanted = [&](double nu) {
    return at_nodes(mesh_, [=](const Vec3& p) { return strain * Vec3{p.x, -nu * p.y, -nu * p.z}; });
  };
  for (const std::string& method : methods()) {
    json options = quick_options(method);
    options["midpoints"] = true;
    const std::vector<Vec3> found = solve(method, mesh_, problem_, options);
    EXPECT_LT(difference(found, wanted(0.3)), 1e-8) << method;
    EXPECT_GT(difference(found, wanted(0.31)), 1e-3) << method << ": another ratio must be told apart";
  }
}

TEST_F(MixedOrder, AColumnUnderItsWeightIsExactInQuadraticElements) {
  // nu = 0, foot held: u_z = -rho g / E (z - z^2 / 2).
  problem_ = {};
  problem_.material = {1e4, 0.0, 1000.0};
  problem_.gravity_m_s2 = {0.0, 0.0, -0.1};
  problem_.held.push_back(
      {faces_where(mesh_, [](const Vec3& p) { return p.z == 0.0; }), {true, true, true}, {}});
  const std::vector<Vec3> wanted = at_nodes(mesh_, [](const Vec3& p) {
    return Vec3{0.0, 0.0, -0.01 * (p.z - 0.5 * p.z * p.z)};
  });
  const auto off = [&](const std::string& method, json options) {
    options["midpoints"] = true;
    return difference(solve(method, mesh_, problem_, options), wanted);
  };
  EXPECT_LT(off("fem.p2_patch", {{"rings", 100}}), 1e-8);
  EXPECT_LT(off("fem.p2_coarse", json::object()), 1e-8);
  EXPECT_LT(off("fem.p2_coarse", {{"added", 0.3}}), 1e-8);
  const double linear = off("fem.p2_patch", {{"rings", -1}});
  EXPECT_GT(linear, 1e-3) << "linear elements do not have it";
  EXPECT_LT(off("fem.p2_patch", {{"rings", 2}}), linear);
  EXPECT_LT(off("fem.p1_modes", few_samples()), linear);
  // Between a vertex and the next, h = 0.2, a linear field misses u'' h^2 / 8 = 5e-5 of the largest 5e-3: a
  // hundredth. Smoothing and irregular tets cost no more than ten times that.
  EXPECT_LT(off("graded.edge_node", json::object()), 0.1);
}

TEST_F(MixedOrder, TheLimitsAreLinearAndQuadraticElements) {
  const json exact{{"rtol", 1e-13}};
  const std::vector<Vec3> linear = at_vertices("fem.p1", exact);
  const std::vector<Vec3> quadratic = solve("fem.p2", mesh_, problem_, exact);
  EXPECT_LT(difference(at_vertices("fem.p2_patch", {{"rings", -1}}), linear), 1e-8);
  EXPECT_LT(difference(at_vertices("fem.p1_modes", {{"modes", 0}, {"samples", 1}}), linear), 1e-8);
  EXPECT_LT(
      difference(solve("fem.p2_patch", mesh_, problem_, {{"rings", 100}, {"midpoints", true}}), quadratic),
      1e-8);
  EXPECT_LT(
      difference(solve("fem.p2_coarse", mesh_, problem_, {{"ratio", 0.0}, {"midpoints", true}}), quadratic),
      1e-8);
  EXPECT_GT(difference(at_vertices("fem.p2_patch", {{"rings", 0}}), linear), 1e-4);
  EXPECT_GT(
      difference(at_vertices("fem.p2_coarse", {{"ratio", 0.7}}),
                 {quadratic.begin(), quadratic.begin() + static_cast<std::ptrdiff_t>(mesh_.points.size())}),
      1e-5);
}

TEST_F(MixedOrder, NestedSpacesHaveFallingPotentials) {
  const double linear = potential("fem.p2_patch", {{"rings", -1}});
  const double near = potential("fem.p2_patch", {{"rings", 0}});
  const double nearer = potential("fem.p2_patch", {{"rings", 1}});
  const double quadratic = potential("fem.p2_patch", {{"rings", 100}});
  EXPECT_LT(near, linear);
  EXPECT_LT(nearer, near);
  EXPECT_LT(quadratic, nearer);
  const double modes = potential("fem.p1_modes", few_samples());
  EXPECT_LT(modes, linear);
  EXPECT_GT(modes, quadratic);
  const double coarse = potential("fem.p2_coarse", {{"ratio", 0.5}});
  EXPECT_LT(potential("fem.p2_coarse", {{"ratio", 0.5}, {"added", 0.3}}), coarse);
}

TEST_F(MixedOrder, ForcesOfSupportsCarryTheLoads) {
  for (const char* method : {"fem.p2_patch", "fem.p2_coarse", "fem.p1_modes"}) {
    const ContestantAnswer answer = run(method, mesh_, problem_, quick_options(method));
    ASSERT_EQ(answer.outcome, "ok") << answer.message;
    Vec3 sum;
    for (const json& force : answer.report.at("support_forces_n"))
      sum = sum + Vec3{force[0].get<double>(), force[1].get<double>(), force[2].get<double>()};
    // The traction on y = 1 is (2, 0, -1) Pa on 1 m^2.
    EXPECT_LT(length(sum + Vec3{2.0, 0.0, -1.0}), 1e-7) << method;
    EXPECT_LT(answer.report.at("residual_relative").get<double>(), 1e-9) << method;
    EXPECT_GT(answer.report.at("stiffness_entries").get<double>(), 0.0) << method;
  }
}

TEST_F(MixedOrder, ModesHelpOnLoadsAndSupportsThatTheyWereNotLearntOn) {
  const std::vector<Vec3> quadratic = at_vertices("fem.p2", json::object());
  const double linear = difference(at_vertices("fem.p1", json::object()), quadratic);
  const json more{{"samples", 60}, {"modes", 50}, {"validate", 6}};
  EXPECT_LT(difference(at_vertices("fem.p1_modes", more), quadratic), 0.5 * linear);
  EXPECT_LT(report_.at("validation_enriched").get<double>(),
            0.5 * report_.at("validation_linear").get<double>());
  json elsewhere = more;
  elsewhere["holdings"] = 3;
  EXPECT_LT(difference(at_vertices("fem.p1_modes", elsewhere), quadratic), linear);
}

TEST_F(MixedOrder, ModesOfAFinerMeshGoBeyondQuadraticElementsOnThisOne) {
  mesh_ = irregular_cube();
  problem_ = supported_cube(mesh_, 0.01);
  json options = few_samples();
  options["samples"] = 40;
  options["modes"] = 40;
  options["refine"] = 1;
  const double linear = potential("fem.p2_patch", {{"rings", -1}});
  const double finest = potential("fem.p1_modes", options);
  EXPECT_LT(finest, linear);
}

TEST_F(MixedOrder, AModulusThatNeedsNoScaleIsLeftAtOne) {
  at_vertices("fem.p2_coarse", {{"ratio", 0.0}, {"scale", "gravity"}});
  EXPECT_NEAR(report_.at("modulus_scale").get<double>(), 1.0, 1e-8);
  at_vertices("fem.p2_patch", {{"rings", -1}, {"scale", "gravity"}});
  EXPECT_LT(report_.at("modulus_scale").get<double>(), 1.0) << "linear elements are too stiff";
  EXPECT_LT(report_.at("fit_off_after").get<double>(), report_.at("fit_off_before").get<double>());
}

TEST_F(MixedOrder, TheSameRequestGivesTheSameBytes) {
  for (const std::string& method : methods()) {
    const std::string first =
        reference::read_text_file(run(method, mesh_, problem_, quick_options(method)).output, 1U << 24U);
    EXPECT_EQ(
        reference::read_text_file(run(method, mesh_, problem_, quick_options(method)).output, 1U << 24U),
        first)
        << method;
  }
}

TEST_F(MixedOrder, SaysWhatItCannotDo) {
  const auto refused = [&](const std::string& method, const json& options, const std::string& why) {
    const ContestantAnswer answer = run(method, mesh_, problem_, options);
    EXPECT_EQ(answer.outcome, "bad_input") << method;
    EXPECT_THAT(answer.message, HasSubstr(why)) << method;
  };
  refused("fem.p2_patch", {{"rings", -2}}, "rings");
  refused("fem.p2_coarse", {{"rings", 1}}, "rings");
  refused("fem.p1_modes", {{"seed", -1}}, "seed");
  refused("graded.edge_node", {{"ratio", 1.0}}, "ratio");
  const BoundaryProblem good = problem_;
  for (const std::string& method : methods()) {
    problem_.strain = StrainSize::kLarge;
    refused(method, json::object(), "is linear");
    problem_ = good;
    problem_.supports.clear();
    refused(method, json::object(), "left free");
    problem_ = good;
  }
  // A force inside the body, which a coarser inside has no vertex for.
  Index inside = 0;
  while (length(mesh_.points[inside] - Vec3{0.5, 0.5, 0.5}) > 0.3) ++inside;
  problem_.nodal_forces.push_back({inside, {0.0, 0.0, -1.0}});
  refused("fem.p2_coarse", json::object(), "forces on the skin");
  refused("graded.edge_node", json::object(), "forces on the skin");
  EXPECT_EQ(run("fem.p2_patch", mesh_, problem_).outcome, "ok");
  problem_ = good;
  problem_.held.push_back({faces_where(mesh_, is_at_x0), {true, true, true}, {}});
  json elsewhere = few_samples();
  elsewhere["holdings"] = 2;
  refused("fem.p1_modes", elsewhere, "holdings");
}

TEST_F(MixedOrder, SpringsAndSmoothedElementsSayWhatAnAnswerCosts) {
  const ContestantAnswer answer = run("smoothed.edge_node", mesh_, problem_, {{"cost", true}});
  ASSERT_EQ(answer.outcome, "ok") << answer.message;
  const ContestantAnswer linear = run("fem.p2_patch", mesh_, problem_, {{"rings", -1}});
  EXPECT_EQ(answer.report.at("unknowns"), linear.report.at("unknowns"));
  EXPECT_GT(answer.report.at("stiffness_entries").get<double>(),
            linear.report.at("stiffness_entries").get<double>());
  EXPECT_FALSE(run("smoothed.edge_node", mesh_, problem_).report.contains("stiffness_entries"));
  problem_.strain = StrainSize::kLarge;
  EXPECT_EQ(run("smoothed.edge_node", mesh_, problem_, {{"cost", true}}).outcome, "bad_input");
}

}  // namespace
}  // namespace palpate::test

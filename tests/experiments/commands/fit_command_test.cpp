// palpate fit as a user starts it, with the real models and the real reference.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "experiments/contestants/contestant.h"
#include "tests/support/experiment_fixture.h"
#include "tests/support/scene_text.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;
using test::run_program;
using testing::HasSubstr;

class FitCommand : public testing::Test {
 protected:
  FitCommand() {
    text_.mesh = "{make: bar, vertices: 200, length_m: 0.1}";
    text_.material = "{young_modulus_pa: 10000, poisson_ratio: 0.45, density_kg_m3: 1000}";
    text_.clamp = "[{half_space: {normal: [1, 0, 0], share: 0.1}, elastic_pa_per_m: 1.0e+6}]";
    folder().add("candidates.yaml",
                 "schema: palpate/candidates/1\n"
                 "simplifiers: [{label: refined, method: palpate.refined, ratios: [0.3]}]\n"
                 "models:\n"
                 "  - {label: van_gelder, method: springs.van_gelder, works: {first: [], second: []}}\n"
                 "  - {label: edge_node, method: smoothed.edge_node, works: {first: [], second: []}}\n");
  }

  const test::ScratchFolder& folder() const { return fixture_.folder(); }
  std::string path(const std::string& name) const { return (folder() / name).string(); }

  test::ProgramResult fit(const std::string& require) {
    text_.rest = require.empty() ? "" : "require: {" + require + "}\n";
    folder().add("scene.yaml", text_.yaml());
    return run_program(
        {"fit", path("scene.yaml"), "-o", path("fit"), "--candidates", path("candidates.yaml")});
  }

  json report() const {
    std::ifstream file(folder() / "fit" / "fit.json");
    return json::parse(file);
  }

  bool has_finite_elements() const {
    const Registry registry = load_registry();
    const auto entry = registry.find("fem.p2");
    return entry && entry->contestant->unavailable().empty();
  }

  test::ExperimentFixture fixture_;
  test::SceneText text_;
};

TEST_F(FitCommand, FindsAModelProvesItAndLeavesAReadyScene) {
  if (!has_finite_elements()) GTEST_SKIP() << "fem.p2 is not built";
  const test::ProgramResult result =
      fit("error: {measure: deformation_l2, at_most: 0.3}, time_per_second_s: 1000");
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const json found = report();
  ASSERT_TRUE(found.at("complete").get<bool>());
  const json& choice = found.at("choice");
  EXPECT_EQ(choice.at("error").size(), 4U);  // the scene and three other loads
  EXPECT_LE(choice.at("worst_error").get<double>(), 0.3);
  EXPECT_GT(choice.at("cost_s").get<double>(), 0.0);
  for (const json& point : found.at("tried")) {
    if (point.at("why_not") == "") {
      EXPECT_LE(point.at("error").front(), 0.3);
    }
  }
  const test::ProgramResult solved =
      run_program({"simulate", path("fit/scene.yaml"), "-o", path("solved"), "--json"});
  ASSERT_EQ(solved.exit_code, 0) << solved.error;
  EXPECT_EQ(json::parse(solved.out).at("tets"), choice.at("tets"));
  EXPECT_TRUE(std::filesystem::exists(folder() / "fit" / "fit.md"));
}

TEST_F(FitCommand, WhereNothingDoesTheNearestIsNamedAndTheExitCodeIsOne) {
  if (!has_finite_elements()) GTEST_SKIP() << "fem.p2 is not built";
  const test::ProgramResult result =
      fit("error: {measure: deformation_l2, at_most: 0.3}, time_per_second_s: 1.0e-9");
  EXPECT_EQ(result.exit_code, 1) << result.error;
  EXPECT_THAT(result.out, HasSubstr("Nothing does."));
  const json found = report();
  EXPECT_TRUE(found.at("choice").is_null());
  EXPECT_THAT(found.at("/nearest/why_not"_json_pointer).get<std::string>(), HasSubstr("takes"));
  EXPECT_FALSE(std::filesystem::exists(folder() / "fit" / "scene.yaml"));
}

TEST_F(FitCommand, RefusesWhatItCannotFit) {
  EXPECT_THAT(fit("").error, HasSubstr("the key \"require\" is missing"));
  const test::ProgramResult cuts = fit("error: {measure: energy, at_most: 0.1}, may_change: [cuts]");
  EXPECT_EQ(cuts.exit_code, 2);
  EXPECT_THAT(cuts.error, AllOf(HasSubstr("no candidate can do all of it"), HasSubstr("cuts")));
  std::filesystem::create_directories(folder() / "fit");
  std::ofstream(folder() / "fit" / "mine.txt") << "mine\n";
  const test::ProgramResult full = fit("error: {measure: energy, at_most: 0.1}");
  EXPECT_EQ(full.exit_code, 2);
  EXPECT_THAT(full.error, HasSubstr("a new or an empty folder"));
}

}  // namespace
}  // namespace palpate::experiments

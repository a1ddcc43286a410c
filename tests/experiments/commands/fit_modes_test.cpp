// palpate fit where modes may do, and palpate simulate on what it leaves.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>

#include "experiments/registry/registry.h"
#include "tests/support/experiment_fixture.h"
#include "tests/support/scene_text.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;
using test::run_program;
using testing::HasSubstr;

/// A bar that hangs from one end, is bent slowly and let go.
class FitModes : public testing::Test {
 protected:
  FitModes() {
    text_.mesh = "{make: bar, vertices: 100, length_m: 0.1}";
    text_.material = "{young_modulus_pa: 10000, poisson_ratio: 0.3, density_kg_m3: 1000}";
    text_.clamp = "[{half_space: {normal: [1, 0, 0], share: 0.1}, elastic_pa_per_m: 1.0e+6}]";
    text_.load =
        "[{force: {half_space: {normal: [-1, 0, 0], share: 0.1}, total_n: [0, 0.002, 0]}, profile: {times_s: "
        "[0, 0.1], shares: [0, 1], smooth: true}, until_s: 0.15}]";
    text_.analysis =
        "{dynamic: {integrator: symplectic_euler, time_step_s: auto, duration_s: 0.3, damping: {stiffness_s: "
        "0.001}}}";
    folder().add("candidates.yaml",
                 "schema: palpate/candidates/1\n"
                 "simplifiers: []\n"
                 "steppings:\n"
                 "  - {label: explicit, integrator: symplectic_euler}\n"
                 "  - {label: modes_1, integrator: exponential, modes: 1}\n"
                 "  - {label: modes_20, integrator: exponential, modes: 20}\n"
                 "models:\n"
                 "  - {label: edge_node, method: smoothed.edge_node, works: {first: [large_strain], second: "
                 "[large_strain]}}\n"
                 "  - {label: modal, method: reduced.modal, set: {modes: 5}, works: {second: []}}\n");
  }

  const test::ScratchFolder& folder() const { return fixture_.folder(); }
  std::string path(const std::string& name) const { return (folder() / name).string(); }

  json fit(const std::string& require) {
    text_.rest += "require: {" + require + "}\n";
    folder().add("scene.yaml", text_.yaml());
    // The elements stepped whole take seconds to start, and a busy machine makes minutes of them.
    const auto result = run_program({"fit", path("scene.yaml"), "-o", path("fit"), "--candidates",
                                     path("candidates.yaml"), "--time-limit", "3000"});
    EXPECT_EQ(result.exit_code, 0) << result.error;
    std::ifstream file(folder() / "fit" / "fit.json");
    return json::parse(file);
  }

  static bool has_finite_elements() {
    const Registry registry = load_registry();
    const auto entry = registry.find("moving_fem.p2");
    return entry && entry->contestant->unavailable().empty();
  }

  test::ExperimentFixture fixture_;
  test::SceneText text_;
};

/// A simulated second by modes is some hundred times cheaper than by explicit steps here, whatever else the
/// machine does.
TEST_F(FitModes, AreTakenWhereTheirOwnMotionIsVerified) {
  ASSERT_TRUE(has_finite_elements()) << "moving_fem.p2 is not built";
  const json found = fit("error: {measure: deformation_l2, at_most: 0.3}");
  const json& choice = found.at("choice");
  ASSERT_EQ(choice.at("method"), "reduced.modal") << found.dump(1);
  EXPECT_EQ(choice.at("error").size(), 6U);
  EXPECT_EQ(found.at("confirming_loads"), 2);
  std::map<std::string, json> tried;
  for (const json& each : choice.at("steppings")) tried[each.at("label")] = each;
  ASSERT_EQ(tried.size(), 2U);  // explicit steps are for others
  const json& taken = choice.at("stepping");
  EXPECT_GT(taken.at("setup_s").get<double>(), 0.0);
  double rest = 0.0;
  for (std::size_t k = 0; k < choice.at("error").size(); ++k)
    rest =
        std::max(rest, choice.at("error")[k].get<double>() + choice.at("reference_error")[k].get<double>());
  EXPECT_GT(taken.at("motion_error").get<double>(), 0.0);
  EXPECT_DOUBLE_EQ(choice.at("worst_error").get<double>(), rest + taken.at("motion_error").get<double>());
  EXPECT_LE(choice.at("worst_error").get<double>(), 0.3);
  bool has_other = false;
  for (const json& point : found.at("checked")) {
    if (point.at("method") == "reduced.modal") continue;
    has_other = true;
    EXPECT_GT(point.at("cost_s").get<double>(), choice.at("cost_s").get<double>());
  }
  EXPECT_TRUE(has_other);
  EXPECT_THAT(test::bytes_of(folder() / "fit/fit.md"), HasSubstr("to be found, which is in no time here"));

  const auto solved = run_program({"simulate", path("fit/scene.yaml"), "-o", path("solved"), "--json"});
  ASSERT_EQ(solved.exit_code, 0) << solved.error;
  const json report = json::parse(solved.out);
  EXPECT_EQ(report.at("method"), "reduced.modal");
  EXPECT_EQ(report.at("modes"), taken.at("modes"));
  EXPECT_EQ(report.at("outcome"), "completed");
  EXPECT_NEAR(report.at("time_step_s").get<double>(), taken.at("time_step_s").get<double>(), 1e-12);
  EXPECT_TRUE(std::filesystem::exists(folder() / "solved/frames.pvd"));
  const auto envelope = run_program({"envelope", path("fit")});
  EXPECT_EQ(envelope.exit_code, 2);
  EXPECT_THAT(envelope.error, HasSubstr("fit.json: the choice is reduced.modal"));
}

TEST_F(FitModes, TooFewAreNotTakenAndItIsSaidWhatTheyLeave) {
  ASSERT_TRUE(has_finite_elements()) << "moving_fem.p2 is not built";
  // Loaded along its length and all at once: one mode is one of its bending.
  text_.load =
      "[{force: {half_space: {normal: [-1, 0, 0], share: 0.1}, total_n: [0.01, 0.001, 0]}, profile: "
      "{times_s: [0, 0.001], shares: [0, 1]}}]";
  const json found = fit("error: {measure: deformation_l2, at_most: 0.3}");
  ASSERT_EQ(found.at("/choice/method"_json_pointer), "reduced.modal");
  const json& steppings = found.at("/choice/steppings"_json_pointer);
  ASSERT_EQ(steppings.size(), 2U);
  EXPECT_THAT(steppings[0].at("why_not").get<std::string>(), HasSubstr("of the motion"));
  EXPECT_GT(steppings[0].at("motion_error").get<double>(), 0.3);
  EXPECT_EQ(steppings[1].at("why_not"), "");
  EXPECT_EQ(found.at("/choice/stepping/modes"_json_pointer), 20);
  EXPECT_THAT(test::bytes_of(folder() / "fit/scene.yaml"), HasSubstr("\"modes\":20"));
}

TEST_F(FitModes, AreNotTriedWhereStrainIsLargeOrIsToRemainPossible) {
  ASSERT_TRUE(has_finite_elements()) << "moving_fem.p2 is not built";
  const json asked = fit("error: {measure: deformation_l2, at_most: 0.5}, large_strain: true");
  EXPECT_EQ(asked.at("dropped"), json({"modal (reduced.modal) cannot do: large_strain"}));
  EXPECT_EQ(asked.at("/choice/method"_json_pointer), "smoothed.edge_node");
  std::filesystem::remove_all(folder() / "fit");
  text_.rest = "strain: large\n";
  const json large = fit("error: {measure: deformation_l2, at_most: 0.5}");
  ASSERT_EQ(large.at("dropped").size(), 1U);
  EXPECT_EQ(large.at("dropped")[0],
            "modal (reduced.modal) are not tried: they are linear, and the scene has large strain");
  EXPECT_EQ(large.at("/choice/method"_json_pointer), "smoothed.edge_node");
}

TEST_F(FitModes, CandidatesSayHowManyAndWithWhatTheyGo) {
  const auto refused = [&](const std::string& stepping, const std::string& reason) {
    folder().add("candidates.yaml",
                 "schema: palpate/candidates/1\nsimplifiers: []\nsteppings: [" + stepping +
                     "]\nmodels: [{label: edge_node, method: smoothed.edge_node, works: {second: []}}]\n");
    text_.rest = "require: {error: {measure: deformation_l2, at_most: 0.5}}\n";
    folder().add("scene.yaml", text_.yaml());
    const auto result =
        run_program({"fit", path("scene.yaml"), "-o", path("fit"), "--candidates", path("candidates.yaml")});
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_THAT(result.error, HasSubstr(reason));
  };
  refused("{label: a, integrator: exponential}", "go together");
  refused("{label: a, integrator: trapezoidal, modes: 3}", "go together");
  refused("{label: a, integrator: exponential, modes: 0}", "modes");
  refused("{label: a, integrator: exponential, modes: 3, precision: single}", "neither precision nor solver");
  refused("{label: a, integrator: exponential, modes: 3}", "at least one that is not of modes");
}

}  // namespace
}  // namespace palpate::experiments

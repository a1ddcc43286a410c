// palpate fit that is stopped before its end: what is known so far is written, and the exit code says which
// it was.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "experiments/files/places.h"
#include "experiments/processes/process.h"
#include "experiments/registry/registry.h"
#include "tests/support/experiment_fixture.h"
#include "tests/support/scene_text.h"

namespace palpate::experiments {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using test::run_program;
using testing::HasSubstr;

class FitStop : public testing::Test {
 protected:
  FitStop() {
    text_.mesh = "{make: bar, vertices: 300, length_m: 0.1}";
    text_.material = "{young_modulus_pa: 10000, poisson_ratio: 0.45, density_kg_m3: 1000}";
    text_.clamp = "[{half_space: {normal: [1, 0, 0], share: 0.1}, elastic_pa_per_m: 1.0e+6}]";
    text_.rest = "require: {error: {measure: deformation_l2, at_most: 0.3}}\n";
    folder().add("scene.yaml", text_.yaml());
    folder().add("candidates.yaml",
                 "schema: palpate/candidates/1\n"
                 "simplifiers: [{label: refined, method: palpate.refined, ratios: [0.2, 0.3, 0.4, 0.5]}]\n"
                 "models:\n"
                 "  - {label: van_gelder, method: springs.van_gelder, works: {first: []}}\n"
                 "  - {label: edge_node, method: smoothed.edge_node, works: {first: []}}\n");
    const Registry registry = load_registry();
    const auto entry = registry.find("fem.p2");
    has_reference_ = entry && entry->contestant->unavailable().empty();
  }

  ~FitStop() override { ::unsetenv("PALPATE_CACHE"); }

  const test::ScratchFolder& folder() const { return fixture_.folder(); }
  std::string path(const std::string& name) const { return (folder() / name).string(); }

  /// Fits the scene, and interrupts it once this shell condition on the folder "$1" holds, however long that
  /// takes.
  ProcessResult interrupt_when(const std::string& condition) const {
    ProcessSpec spec;
    spec.standard_output = folder() / "out";
    spec.standard_error = folder() / "error";
    spec.arguments = {
        "/bin/sh", "-c",
        "\"$0\" fit \"$1/scene.yaml\" -o \"$1/fit\" --candidates \"$1/candidates.yaml\" & p=$!; "
        "while ! " +
            condition +
            " 2> /dev/null && kill -0 $p; do sleep 0.02; done; kill -INT $p; "
            "wait $p",
        program_folder() + "/palpate", folder().path().string()};
    return run_process(spec);
  }
  std::string said() const { return test::bytes_of(folder() / "error"); }

  /// fit.json of one that was stopped, with what holds of each.
  json stopped_fit(std::size_t candidates) const {
    if (!fs::exists(folder() / "fit/fit.json")) {
      ADD_FAILURE() << "no fit.json";
      return {};
    }
    json fit = json::parse(test::bytes_of(folder() / "fit/fit.json"));
    EXPECT_EQ(fit.at("schema"), "palpate/fit/1");
    EXPECT_FALSE(fit.at("complete").get<bool>());
    EXPECT_TRUE(fit.at("choice").is_null());
    EXPECT_EQ(fit.at("tried").size(), candidates) << "all candidates, run or not";
    EXPECT_FALSE(fs::exists(folder() / "fit/scene.yaml"));
    EXPECT_THAT(test::bytes_of(folder() / "fit/fit.md"),
                HasSubstr("The search was stopped before all was tried."));
    return fit;
  }

  test::ExperimentFixture fixture_;
  test::SceneText text_;
  bool has_reference_ = false;
};

/// The least limit there is: a second, of which the references alone take longer.
TEST_F(FitStop, AtTheTimeLimitItSaysWhatItKnows) {
  ASSERT_TRUE(has_reference_) << "fem.p2 is not built";
  ::setenv("PALPATE_CACHE", path("cache").c_str(), 1);  // references of an earlier run would be there at once
  const test::ProgramResult result =
      run_program({"fit", path("scene.yaml"), "-o", path("fit"), "--candidates", path("candidates.yaml"),
                   "--time-limit", "1"});
  EXPECT_EQ(result.exit_code, 1) << result.error;
  EXPECT_THAT(result.error, HasSubstr("stopped before all was tried: what is known so far is written"));
  const json fit = stopped_fit(10);
  std::size_t not_run = 0;
  for (const json& point : fit.at("tried")) {
    if (point.at("why_not") == "not run") ++not_run;
  }
  EXPECT_GE(not_run, 1U);
}

TEST_F(FitStop, CtrlCLeavesWhatIsKnownAndNamesTheNearest) {
  ASSERT_TRUE(has_reference_) << "fem.p2 is not built";
  const ProcessResult result =
      interrupt_when("grep -q '\"label\":\"edge_node-' \"$1/fit/search/run/records.jsonl\"");
  EXPECT_EQ(result.exit_code, 130) << said();
  EXPECT_THAT(said(), HasSubstr("stopped before all was tried: what is known so far is written"));
  const json fit = stopped_fit(10);
  std::size_t known = 0;
  for (const json& point : fit.at("tried")) {
    if (!point.at("error").empty()) ++known;
  }
  EXPECT_GE(known, 1U);
  EXPECT_FALSE(fit.at("nearest").is_null());
  EXPECT_THAT(test::bytes_of(folder() / "fit/fit.md"),
              HasSubstr("What comes closest is " + fit.at("/nearest/name"_json_pointer).get<std::string>()));
  // Each case that was judged can be looked at and run again.
  EXPECT_TRUE(fs::exists(folder() / "fit/search/plan.yaml"));
}

/// A motion of minutes, interrupted when it has begun: the search is over by then, and all of it is written.
TEST_F(FitStop, CtrlCInAMotionLeavesTheSearch) {
  ASSERT_TRUE(has_reference_) << "fem.p2 is not built";
  text_.load =
      "[{force: {half_space: {normal: [-1, 0, 0], share: 0.1}, total_n: [0, 0.02, 0]}, "
      "profile: {times_s: [0, 0.1], shares: [0, 1]}}]";
  text_.analysis =
      "{dynamic: {integrator: symplectic_euler, time_step_s: auto, duration_s: 1000, damping: {mass_per_s: "
      "20}}}";
  folder().add("scene.yaml", text_.yaml());
  folder().add("candidates.yaml",
               "schema: palpate/candidates/1\nsimplifiers: []\n"
               "models: [{label: edge_node, method: smoothed.edge_node, works: {second: []}}]\n"
               "steppings: [{label: explicit, integrator: symplectic_euler}]\n");
  const ProcessResult result = interrupt_when("ls \"$1\"/fit/check_0/motion/*/*/body*");
  EXPECT_EQ(result.exit_code, 130) << said();
  EXPECT_THAT(said(), HasSubstr("stopped before all was tried: what is known so far is written"));
  const json fit = stopped_fit(1);
  EXPECT_EQ(fit.at("/tried/0/error"_json_pointer).size(), 1U);
  EXPECT_EQ(fit.at("/checked/0/error"_json_pointer).size(), 4U);
  EXPECT_THAT(fit.at("/checked/0/why_not"_json_pointer).get<std::string>(), HasSubstr("motion"));
}

}  // namespace
}  // namespace palpate::experiments

// palpate fit as a user starts it, with the real models and the real reference.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <set>

#include "experiments/envelope/envelope_search.h"
#include "experiments/registry/registry.h"
#include "experiments/scene_reader/scene.h"
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
  ASSERT_TRUE(has_finite_elements()) << "fem.p2 is not built";
  const test::ProgramResult result =
      fit("error: {measure: deformation_l2, at_most: 0.3}, time_per_second_s: 1000");
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const json found = report();
  ASSERT_TRUE(found.at("complete").get<bool>());
  const json& choice = found.at("choice");
  EXPECT_EQ(choice.at("error").size(), 6U);  // the scene, three other loads, two that confirm the choice
  EXPECT_EQ(found.at("confirming_loads"), 2);
  EXPECT_LE(choice.at("worst_error").get<double>(), 0.3);
  EXPECT_GT(choice.at("cost_s").get<double>(), 0.0);
  for (const json& point : found.at("tried")) {
    if (point.at("why_not") == "") {
      EXPECT_LE(point.at("error").front(), 0.3);
    }
    EXPECT_NE(point.at("not_taken"), "") << "who reads the table asks why of each";
    EXPECT_EQ(point.at("not_taken") == "taken", point.at("name") == choice.at("name"));
  }
  EXPECT_THAT(test::bytes_of(folder() / "fit" / "fit.md"), HasSubstr("| looked at on other loads, too |"));
  const test::ProgramResult solved =
      run_program({"simulate", path("fit/scene.yaml"), "-o", path("solved"), "--json"});
  ASSERT_EQ(solved.exit_code, 0) << solved.error;
  EXPECT_EQ(json::parse(solved.out).at("tets"), choice.at("tets"));
  EXPECT_TRUE(std::filesystem::exists(folder() / "fit" / "fit.md"));
  // What takes hold of a simplified mesh is carried over from the whole one, in the fit as here.
  const bool is_simplified = choice.at("simplify") != "none";
  EXPECT_EQ(std::filesystem::exists(folder() / "fit" / "whole.mesh"), is_simplified);
  EXPECT_EQ(!read_scene(folder() / "fit" / "scene.yaml").mesh.regions_from.empty(), is_simplified);
}

/// The far end of a bar that hangs from its other one: a tolerance there holds there, in the search, on other
/// loads and in what is written, and a place without vertices is refused before anything is solved.
TEST_F(FitCommand, AToleranceMayHoldAtAPlaceAlone) {
  ASSERT_TRUE(has_finite_elements()) << "fem.p2 is not built";
  text_.mesh = "{make: bar, vertices: 100, length_m: 0.1}";
  const std::string asked = "error: {measure: relative_l2, at_most: 0.5, at: ";
  const test::ProgramResult nowhere =
      fit(asked + "[{sphere: {center_m: [0.031, 0.001, 0.001], radius_m: 1.0e-5}}]}");
  EXPECT_EQ(nowhere.exit_code, 2);
  EXPECT_THAT(nowhere.error, AllOf(HasSubstr("scene.yaml:7"), HasSubstr("has no vertex of the mesh in it")));
  std::filesystem::remove_all(folder() / "fit");
  const test::ProgramResult result = fit(asked + "[{half_space: {normal: [-1, 0, 0], share: 0.2}}]}");
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const json found = report();
  EXPECT_EQ(found.at("measure"), "displacement_l2_at");
  EXPECT_LE(found.at("/choice/worst_error"_json_pointer).get<double>(), 0.5);
  std::ifstream records(folder() / "fit/search/run/records.jsonl");
  std::size_t judged = 0;
  for (std::string line; std::getline(records, line);) {
    const json record = json::parse(line);
    if (record.at("outcome") != "accepted") continue;
    ++judged;
    if (record.at("label") == "reference") {
      EXPECT_GT(record.at("/judge/points_at"_json_pointer).get<int>(), 3);
      EXPECT_GT(record.at("/judge/reference_error_l2_at"_json_pointer).get<double>(), 0.0);
    } else {
      const json& judge = record.at("judge");
      EXPECT_NE(judge.at("displacement_l2_at"), judge.at("displacement_l2"));
    }
  }
  EXPECT_GE(judged, 5U);
  EXPECT_THAT(test::bytes_of(folder() / "fit/scene.yaml"), HasSubstr("\"at\":[{\"half_space\":"));
  EXPECT_THAT(test::bytes_of(folder() / "fit/fit.md"), HasSubstr(" at half_space"));
}

TEST_F(FitCommand, WhereNothingDoesTheNearestIsNamedAndTheExitCodeIsOne) {
  ASSERT_TRUE(has_finite_elements()) << "fem.p2 is not built";
  const test::ProgramResult result =
      fit("error: {measure: deformation_l2, at_most: 0.3}, time_per_second_s: 1.0e-9");
  EXPECT_EQ(result.exit_code, 1) << result.error;
  EXPECT_THAT(result.out, HasSubstr("Nothing was found that does."));
  const json found = report();
  EXPECT_TRUE(found.at("choice").is_null());
  EXPECT_THAT(found.at("/nearest/why_not"_json_pointer).get<std::string>(), HasSubstr("takes"));
  EXPECT_FALSE(std::filesystem::exists(folder() / "fit" / "scene.yaml"));
}

/// A bar that is pulled, fitted and then taken to its borders. Symplectic Euler's border is known: without
/// damping 1/0.9 times the step of `auto`, which is nine tenths of the longest stable one.
TEST_F(FitCommand, AnEnvelopeSaysHowFarTheModelGoesAndSimulateWarnsBeyond) {
  ASSERT_TRUE(has_finite_elements()) << "fem.p2 is not built";
  text_.mesh = "{make: bar, vertices: 100, length_m: 0.1}";
  text_.load =
      "[{force: {half_space: {normal: [-1, 0, 0], share: 0.1}, total_n: [0.02, 0, 0]}, "
      "profile: {times_s: [0, 0.2], shares: [0, 1], smooth: true}}]";
  text_.analysis =
      "{dynamic: {integrator: symplectic_euler, time_step_s: auto, duration_s: 0.25, damping: {mass_per_s: "
      "20}}}";
  ASSERT_EQ(fit("error: {measure: deformation_l2, at_most: 0.6}").exit_code, 0);
  const std::string before = test::bytes_of(folder() / "fit/scene.yaml");
  const test::ProgramResult result = run_program({"envelope", path("fit"), "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const json envelope = json::parse(result.out);
  ASSERT_EQ(envelope.at("axes").size(), 5U);
  std::map<std::string, json> axis;
  for (const json& each : envelope.at("axes")) axis[each.at("name")] = each;
  const json& step = axis.at("step");
  EXPECT_GE(step.at("holds_to").get<double>(), 1.0);
  EXPECT_LE(step.at("holds_to").get<double>(), 1.02 / 0.9) << step.dump(1);
  EXPECT_LE(step.at("fails_at").get<double>(), 1.02 * kEnvelopeResolution / 0.9) << step.dump(1);
  // A step is too long by the square root of what the body is too light; Young's modulus does not stiffen the
  // support, which has its share in the fastest motion.
  const double lighter = axis.at("lighter").at("holds_to").get<double>();
  EXPECT_LE(lighter, 1.04 / 0.81) << axis.at("lighter").dump(1);
  EXPECT_GE(kEnvelopeResolution * axis.at("stiffer").at("holds_to").get<double>(), lighter);
  for (const auto& [name, each] : axis) {
    for (const json& probe : each.at("probes")) {
      if (!probe.at("ending").is_null()) continue;
      const double sum = probe.at("rest_error").get<double>() + probe.at("reference_error").get<double>() +
                         probe.at("step_error").get<double>();
      EXPECT_LE(sum, 0.6) << name;
    }
  }
  EXPECT_EQ(test::bytes_of(folder() / "fit/envelope.png").substr(1, 3), "PNG");

  const auto warnings = [&](const std::string& from, const std::string& to) {
    std::string text = test::bytes_of(folder() / "fit/scene.yaml");
    if (!from.empty()) {
      EXPECT_NE(text.find(from), std::string::npos) << text;
      text.replace(text.find(from), from.size(), to);
    }
    folder().add("fit/changed.yaml", text);
    const test::ProgramResult run = run_program({"simulate", path("fit/changed.yaml"), "-o", path("solved")});
    return run.error;
  };
  EXPECT_EQ(test::bytes_of(folder() / "fit/scene.yaml"), before + "envelope: envelope.json\n");
  EXPECT_THAT(warnings("", ""), Not(HasSubstr("outside")));
  EXPECT_THAT(warnings("\"young_modulus_pa\":10000", "\"young_modulus_pa\":1e6"),
              HasSubstr("outside of what was fitted: Young's modulus times 100, measured to hold up to"));
  EXPECT_THAT(warnings("\"poisson_ratio\":0.45", "\"poisson_ratio\":0.3"),
              HasSubstr("Poisson's ratio is another"));
  EXPECT_THAT(warnings("\"elastic_pa_per_m\":1000000.0", "\"elastic_pa_per_m\":500000.0"),
              HasSubstr("outside of what was fitted: support 1: elastic_pa_per_m is 500000"));
  EXPECT_THAT(run_program({"envelope", path("fit")}).error, HasSubstr("expected a fit without an envelope"));
  std::ofstream(folder() / "fit/envelope.json") << "{\"schema\": \"palpate/envelope/1\"}";
  EXPECT_THAT(warnings("", ""), HasSubstr("not as palpate envelope leaves it"));
}

/// A stiff bar that is pushed slowly: its waves take 50 us from vertex to vertex, its motion a tenth of a
/// second. The trapezoidal rule follows it at steps that are longer by far; what is taken is the cheapest of
/// those that hold, by the times that were measured, and what an engine cannot take is named.
TEST_F(FitCommand, AMovingSceneIsSteppedByWhatIsVerified) {
  ASSERT_TRUE(has_finite_elements()) << "fem.p2 is not built";
  text_.mesh = "{make: bar, vertices: 100, length_m: 0.1}";
  text_.material = "{young_modulus_pa: 1.0e+6, poisson_ratio: 0.3, density_kg_m3: 1000}";
  text_.clamp = "[{half_space: {normal: [1, 0, 0], share: 0.1}, elastic_pa_per_m: 1.0e+8}]";
  text_.load =
      "[{force: {half_space: {normal: [-1, 0, 0], share: 0.1}, total_n: [0, 0.2, 0]}, "
      "profile: {times_s: [0, 0.1], shares: [0, 1], smooth: true}}]";
  text_.analysis =
      "{dynamic: {integrator: velocity_verlet, time_step_s: auto, duration_s: 0.12, damping: {mass_per_s: "
      "20}}}";
  folder().add("candidates.yaml",
               "schema: palpate/candidates/1\nsimplifiers: []\n"
               "models: [{label: edge_node, method: smoothed.edge_node, works: {second: []}}]\n"
               "steppings:\n"
               "  - {label: explicit, integrator: symplectic_euler}\n"
               "  - {label: no_engine, integrator: runge_kutta_4, precision: single}\n"
               "  - {label: trapezoidal, integrator: trapezoidal}\n");
  ASSERT_EQ(fit("error: {measure: deformation_l2, at_most: 0.3}, time_per_second_s: 10000").exit_code, 0);
  const json found = report();
  const json& choice = found.at("choice");
  std::map<std::string, json> tried;
  for (const json& each : choice.at("steppings")) tried[each.at("label")] = each;
  EXPECT_THAT(tried.at("no_engine").at("why_not").get<std::string>(), HasSubstr("precision"));
  ASSERT_EQ(tried.at("explicit").at("why_not"), "");
  ASSERT_EQ(tried.at("trapezoidal").at("why_not"), "");
  EXPECT_GT(tried.at("trapezoidal").at("time_step_s").get<double>(),
            20.0 * tried.at("explicit").at("time_step_s").get<double>());
  const json& taken = choice.at("stepping");
  const double cost = tried.at(taken.at("label")).at("cost_s").get<double>();
  for (const char* label : {"explicit", "trapezoidal"}) {
    EXPECT_LE(cost, tried.at(label).at("cost_s").get<double>()) << label;
    EXPECT_GT(tried.at(label).at("motion_error").get<double>(), 0.0) << label;
    EXPECT_GT(tried.at(label).at("memory_bytes").get<double>(), 1e6) << label;
  }
  double rest = 0.0;
  for (std::size_t k = 0; k < choice.at("error").size(); ++k)
    rest =
        std::max(rest, choice.at("error")[k].get<double>() + choice.at("reference_error")[k].get<double>());
  EXPECT_DOUBLE_EQ(choice.at("worst_error").get<double>(), rest + taken.at("motion_error").get<double>());
  EXPECT_THAT(test::bytes_of(folder() / "fit/scene.yaml"),
              HasSubstr("\"integrator\":" + taken.at("integrator").dump()));
  const test::ProgramResult solved =
      run_program({"simulate", path("fit/scene.yaml"), "-o", path("solved"), "--json"});
  ASSERT_EQ(solved.exit_code, 0) << solved.error;
  EXPECT_NEAR(json::parse(solved.out).at("time_step_s").get<double>(), taken.at("time_step_s").get<double>(),
              1e-12);
}

/// A bar of which two thirds lie in a stiff bed: they hardly move, and are held at rest where that costs
/// less. Whether it does is the clock's to say; errors, files and waking are not.
TEST_F(FitCommand, APartThatHardlyMovesMayBeHeldAndWakes) {
  ASSERT_TRUE(has_finite_elements()) << "fem.p2 is not built";
  text_.mesh = "{make: bar, vertices: 200, length_m: 0.1}";
  text_.material = "{young_modulus_pa: 1.0e+6, poisson_ratio: 0.3, density_kg_m3: 1000}";
  text_.clamp = "[{half_space: {normal: [1, 0, 0], share: 0.6}, elastic_pa_per_m: 1.0e+8}]";
  text_.load =
      "[{force: {half_space: {normal: [-1, 0, 0], share: 0.1}, total_n: [0, 0.2, 0]}, "
      "profile: {times_s: [0, 0.05], shares: [0, 1], smooth: true}}]";
  text_.analysis =
      "{dynamic: {integrator: symplectic_euler, time_step_s: auto, duration_s: 0.06, damping: {mass_per_s: "
      "20}}}";
  folder().add("candidates.yaml",
               "schema: palpate/candidates/1\nsimplifiers: []\n"
               "models: [{label: blend, method: smoothed.blend, works: {second: []}}]\n"
               "steppings: [{label: explicit, integrator: symplectic_euler}]\n");
  ASSERT_EQ(fit("error: {measure: deformation_l2, at_most: 0.35}").exit_code, 0);
  const json found = report();
  ASSERT_FALSE(found.at("frozen").empty());
  const json& held = found.at("frozen")[0];
  EXPECT_GT(held.at("tets").get<int>(), 100);
  EXPECT_GT(held.at("most_force_n").get<double>(), 0.0);
  EXPECT_LE(held.at("worst_error").get<double>() + held.at("motion_error").get<double>(), 0.35);
  EXPECT_LE(found.at("/choice/worst_error"_json_pointer).get<double>(), 0.35);
  const bool is_taken = found.at("frozen").back().at("why_not") == "";
  EXPECT_EQ(is_taken, std::filesystem::exists(folder() / "fit/frozen.json"));
  EXPECT_EQ(is_taken, found.at("/choice/set"_json_pointer).contains("frozen"));
  if (!is_taken) {
    EXPECT_THAT(found.at("frozen").back().at("why_not").get<std::string>(), HasSubstr("the whole model"));
  }
  // The part as it was verified, whatever it costs: under the same loads it stays, under ten times as much it
  // wakes.
  json scene = json::parse(test::bytes_of(folder() / "fit/still/0/held_0/scene.yaml"));
  json frozen = json::parse(test::bytes_of(folder() / "fit/still/0/frozen.json"));
  frozen["most_force_n"] = held.at("most_force_n");
  scene["model"]["frozen"] = "mine.json";
  folder().add("mine.json", frozen.dump());
  const auto simulate = [&](double factor) {
    scene["load"][0]["force"]["total_n"] = {0.0, 0.2 * factor, 0.0};
    folder().add("held.yaml", scene.dump());
    return run_program({"simulate", path("held.yaml"), "-o", path("solved"), "--json"});
  };
  const test::ProgramResult still = simulate(1.0);
  EXPECT_EQ(json::parse(still.out).at("frozen_vertices"), held.at("vertices")) << still.error;
  EXPECT_THAT(still.error, Not(HasSubstr("wakes")));
  const test::ProgramResult woken = simulate(10.0);
  EXPECT_EQ(woken.exit_code, 0) << woken.error;
  EXPECT_THAT(woken.error, HasSubstr("it wakes, and the whole model is stepped from the start"));
  EXPECT_EQ(json::parse(woken.out).at("frozen_vertices"), 0);
  scene["model"].erase("frozen");
  const test::ProgramResult whole = simulate(10.0);
  EXPECT_EQ(json::parse(whole.out).at("state_hash"), json::parse(woken.out).at("state_hash"));
  frozen["of_vertices"] = 7;
  folder().add("mine.json", frozen.dump());
  scene["model"]["frozen"] = "mine.json";
  EXPECT_THAT(simulate(1.0).error, HasSubstr("mine.json: expected a mesh of"));
}

TEST_F(FitCommand, AnEnvelopeIsMeasuredOfAFitAlone) {
  const test::ProgramResult none = run_program({"envelope", path("")});
  EXPECT_EQ(none.exit_code, 2);
  EXPECT_THAT(none.error, HasSubstr("expected a folder that palpate fit has written"));
  folder().add("fit.json", R"({"schema": "palpate/fit/1", "choice": null})");
  EXPECT_THAT(run_program({"envelope", path("")}).error, HasSubstr("no model that meets its tolerance"));
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

/// Where supports may change, what keeps a matrix is left out; where nothing else is there, that is an error.
TEST_F(FitCommand, WithoutASteppingThatKeepsChangesPossibleNothingIsRun) {
  text_.analysis = "{dynamic: {integrator: symplectic_euler, time_step_s: auto, duration_s: 0.1}}";
  folder().add("candidates.yaml",
               "schema: palpate/candidates/1\nsimplifiers: []\n"
               "models: [{label: edge_node, method: smoothed.edge_node, works: {second: [supports]}}]\n"
               "steppings: [{label: factored, integrator: bdf2}]\n");
  const test::ProgramResult none = fit("error: {measure: energy, at_most: 0.1}, may_change: [supports]");
  EXPECT_EQ(none.exit_code, 2);
  EXPECT_THAT(none.error, AllOf(HasSubstr("require: no stepping can do all of it"),
                                HasSubstr("factored (bdf2 steps) are not tried: they need a new set-up for a "
                                          "change of supports")));
}

// Sizes are found on the scene's own loads: on other loads the candidate has the same mesh.
TEST_F(FitCommand, AGradedMeshIsTheSameOnOtherLoads) {
  ASSERT_TRUE(has_finite_elements()) << "fem.p2 is not built";
  folder().add("candidates.yaml",
               "schema: palpate/candidates/1\n"
               "simplifiers:\n"
               "  - {label: plain, method: palpate.refined, ratios: [0.4]}\n"
               "  - {label: graded, method: palpate.refined, ratios: [0.4], grade: {near: [supports], "
               "near_size: 0.3}}\n"
               "  - {label: padded, method: palpate.refined, ratios: [0.4], grade: {near: [pads]}}\n"
               "models: [{label: edge_node, method: smoothed.edge_node, works: {first: [], second: []}}]\n");
  text_.mesh = "{make: bar, vertices: 300, length_m: 0.1}";
  const test::ProgramResult result =
      fit("error: {measure: deformation_l2, at_most: 0.6}, time_per_second_s: 1000");
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const json found = report();
  ASSERT_EQ(found.at("dropped").size(), 1U) << found.at("dropped");
  EXPECT_THAT(found.at("dropped").front().get<std::string>(), HasSubstr("padded (graded palpate.refined)"));
  std::map<std::string, std::set<std::string>> meshes;  // by simplifier
  for (const auto& entry :
       std::filesystem::recursive_directory_iterator(folder() / "fit" / "check_0" / "run" / "problems")) {
    if (entry.path().filename() != "in.mesh") continue;
    const std::string place = entry.path().string();
    const bool is_between =
        place.find("=0.4/") == std::string::npos;  // a share that the fit looked at by itself
    for (const char* label : {"=graded", "=plain"}) {
      if (!is_between && place.find(label) != std::string::npos)
        meshes[label].insert(test::bytes_of(entry.path()));
    }
  }
  ASSERT_EQ(meshes["=graded"].size(), 1U);
  ASSERT_EQ(meshes["=plain"].size(), 1U);
  EXPECT_NE(meshes["=graded"], meshes["=plain"]);
}

TEST_F(FitCommand, AGradedSimplifierHasOneShareAndTakesSizes) {
  const auto refused = [&](const std::string& simplifier, const std::string& reason) {
    folder().add("candidates.yaml",
                 "schema: palpate/candidates/1\nsimplifiers: [" + simplifier +
                     "]\nmodels: [{label: edge_node, method: smoothed.edge_node, works: {first: []}}]\n");
    const test::ProgramResult result = fit("error: {measure: deformation_l2, at_most: 0.6}");
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_THAT(result.error, HasSubstr(reason));
  };
  refused("{label: a, method: palpate.refined, ratios: [0.4, 0.5], grade: {near: [supports]}}", "one share");
  refused("{label: a, method: palpate.outcome, ratios: [0.4], grade: {near: [supports]}}",
          "cannot be graded");
  refused("{label: a, method: palpate.refined, ratios: [0.4], grade: {near: [fingers]}}", "fingers");
}

}  // namespace
}  // namespace palpate::experiments

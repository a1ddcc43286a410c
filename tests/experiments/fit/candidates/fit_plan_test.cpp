// What a fit tries: candidates as data, loads that the choice never saw, the plan of its search.
#include "experiments/fit/candidates/fit_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <map>
#include <numbers>
#include <set>

#include "core/base/error.h"
#include "core/base/types.h"
#include "experiments/grading/graded_mesh.h"
#include "experiments/plan_reader/case_list.h"
#include "experiments/runner/contest_table.h"
#include "experiments/runner/read_plan.h"
#include "tests/support/scene_text.h"
#include "tests/support/scratch_folder.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;
using testing::HasSubstr;

Vec3 as_vector(const json& list) {
  return {list[0].get<double>(), list[1].get<double>(), list[2].get<double>()};
}

double angle_between(const Vec3& a, const Vec3& b) {
  return std::acos(std::min(1.0, dot(a, b) / (length(a) * length(b))));
}

const json kPressed = json::parse(R"({
  "clamp": [{"half_space": {"normal": [0, 1, 0], "share": 0.2}, "elastic_pa_per_m": 1e6}],
  "load": [{"gravity_m_s2": [0, 0, -9.81]},
           {"force": {"sphere": {"center_m": [0.01, 0.02, 0.03], "radius_m": 0.01}, "total_n": [0, -1, 0]}},
           {"displace": {"sphere": {"surface_point": {"direction": [0.2, 1, 0.3]}, "radius_m": 0.015},
                         "by_m": [0, -0.002, 0], "elastic_pa_per_m": 5e6}}]})");

TEST(PerturbedScene, OneSeedGivesOneSceneAndAnotherAnother) {
  EXPECT_EQ(perturbed_scene(kPressed, 1), perturbed_scene(kPressed, 1));
  EXPECT_NE(perturbed_scene(kPressed, 1), perturbed_scene(kPressed, 2));
  EXPECT_NE(perturbed_scene(kPressed, 1), kPressed);
}

TEST(PerturbedScene, LiesOnTheBorderOfWhatItSays) {
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const json scene = perturbed_scene(kPressed, seed);
    EXPECT_EQ(scene["clamp"], kPressed["clamp"]);
    const auto held = [&](const json::json_pointer& at) {
      const Vec3 before = as_vector(kPressed.at(at));
      const Vec3 after = as_vector(scene.at(at));
      EXPECT_NEAR(angle_between(before, after), std::numbers::pi / 6.0, 1e-9) << seed;
      EXPECT_NEAR(std::abs(length(after) / length(before) - 1.0), 0.3, 1e-12) << seed;
    };
    held("/load/0/gravity_m_s2"_json_pointer);
    held("/load/1/force/total_n"_json_pointer);
    held("/load/2/displace/by_m"_json_pointer);
    const Vec3 moved =
        as_vector(scene.at("/load/1/force/sphere/center_m"_json_pointer)) - Vec3{0.01, 0.02, 0.03};
    EXPECT_NEAR(length(moved), 0.005, 1e-12) << seed;
    EXPECT_NEAR(
        angle_between({0.2, 1.0, 0.3},
                      as_vector(scene.at("/load/2/displace/sphere/surface_point/direction"_json_pointer))),
        std::numbers::pi / 12.0, 1e-9)
        << seed;
  }
}

/// Loads drawn from the whole range reach all of it, and nothing beyond.
TEST(PerturbedScene, DrawnFromTheWholeRangeItLiesAnywhereInIt) {
  double most_turn = 0.0;
  double least_turn = 1.0;
  double least = 2.0;
  double most = 0.0;
  double farthest = 0.0;
  const auto at = "/load/1/force/total_n"_json_pointer;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const json scene = perturbed_scene(kPressed, seed, LoadRange::kWhole);
    EXPECT_EQ(scene, perturbed_scene(kPressed, seed, LoadRange::kWhole));
    const Vec3 before = as_vector(kPressed.at(at));
    const Vec3 after = as_vector(scene.at(at));
    const double turn = angle_between(before, after);
    most_turn = std::max(most_turn, turn);
    least_turn = std::min(least_turn, turn);
    least = std::min(least, length(after) / length(before));
    most = std::max(most, length(after) / length(before));
    const Vec3 moved =
        as_vector(scene.at("/load/1/force/sphere/center_m"_json_pointer)) - Vec3{0.01, 0.02, 0.03};
    farthest = std::max(farthest, length(moved));
  }
  EXPECT_LT(least_turn, 0.02);
  EXPECT_GT(most_turn, 0.5);
  EXPECT_LE(most_turn, std::numbers::pi / 6.0 + 1e-9);
  EXPECT_LT(least, 0.72);
  EXPECT_GE(least, 0.7 - 1e-12);
  EXPECT_GT(most, 1.28);
  EXPECT_LE(most, 1.3 + 1e-12);
  EXPECT_GT(farthest, 0.0049);
  EXPECT_LE(farthest, 0.005 + 1e-12);
}

/// Five loads on a cone about the scene's own leave no wide gap: 72 degrees apart they would lie evenly.
TEST(PerturbedScene, TheFirstFiveLieAroundTheScenesOwn) {
  for (const auto& at : {"/load/0/gravity_m_s2"_json_pointer, "/load/1/force/total_n"_json_pointer,
                         "/load/2/displace/by_m"_json_pointer}) {
    const Vec3 axis = as_vector(kPressed.at(at));
    const Vec3 along = (1.0 / length(axis)) * axis;
    const Vec3 any = cross(along, Vec3{1.0, 0.0, 0.0});
    const Vec3 first = (1.0 / length(any)) * any;
    const Vec3 second = cross(along, first);
    std::vector<double> azimuths;
    for (std::uint64_t number = 1; number <= 5; ++number) {
      const Vec3 v = as_vector(perturbed_scene(kPressed, number).at(at));
      azimuths.push_back(std::atan2(dot(v, second), dot(v, first)));
    }
    std::sort(azimuths.begin(), azimuths.end());
    azimuths.push_back(azimuths.front() + 2.0 * std::numbers::pi);
    for (std::size_t k = 0; k < 5; ++k)
      EXPECT_LT(azimuths[k + 1] - azimuths[k], 0.75 * std::numbers::pi) << at.to_string() << " " << k;
  }
}

class FitPlans : public testing::Test {
 protected:
  FitCandidates read_text(const std::string& text) const {
    return read_candidates(folder_.add("candidates.yaml", text), registry_);
  }

  /// What the text is refused with.
  std::string refusal_of(const std::string& text) const {
    try {
      read_text(text);
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  }

  test::ScratchFolder folder_;
  Registry registry_ = load_registry();
};

TEST_F(FitPlans, TheCandidatesOfTheProjectAreGood) {
  const FitCandidates candidates = read_candidates(candidates_path(), registry_);
  EXPECT_GE(candidates.models.size(), 6U);
  EXPECT_GE(candidates.simplifiers.size(), 2U);
  std::set<std::string> labels;
  const auto is_known = [&](const std::string& label, const std::string& method, const char* contest) {
    EXPECT_TRUE(labels.insert(label).second) << label << " twice";
    const auto entry = registry_.find(method);
    ASSERT_TRUE(entry.has_value()) << method;
    EXPECT_EQ(entry->contestant->contest, contest) << method;
    const std::string why = entry->contestant->unavailable();
    if (!why.empty()) std::cout << "[  missing ] " << method << ": " << why << '\n';
  };
  for (const FitSimplifier& simplifier : candidates.simplifiers) {
    is_known(simplifier.label, simplifier.method, "simplify");
    EXPECT_EQ(std::set<double>(simplifier.ratios.begin(), simplifier.ratios.end()).size(),
              simplifier.ratios.size())
        << simplifier.label << ": a share twice";
    if (simplifier.grade && !simplifier.grade->pilot.empty()) {
      EXPECT_TRUE(registry_.find(simplifier.grade->pilot)->contestant->unavailable().empty());
    }
  }
  std::map<std::string, std::set<std::string>> by_work;  // methods that are there
  std::set<std::string> words{"large_strain"};
  words.insert(changeable_things().begin(), changeable_things().end());
  const auto are_known = [&](const std::string& label, const std::vector<std::string>& things) {
    EXPECT_EQ(std::set<std::string>(things.begin(), things.end()).size(), things.size()) << label;
    for (const std::string& thing : things) EXPECT_EQ(words.count(thing), 1U) << label << ": " << thing;
  };
  for (const FitModel& model : candidates.models) {
    is_known(model.label, model.method, "deform");
    EXPECT_FALSE(model.works.empty()) << model.label;
    for (const auto& [work, can] : model.works) {
      are_known(model.label, can);
      if (registry_.find(model.method)->contestant->unavailable().empty()) by_work[work].insert(model.method);
    }
  }
  for (const FitWork work : {FitWork::kFirst, FitWork::kFurther, FitWork::kSecond}) {
    EXPECT_FALSE(by_work[work_name(work)].empty()) << "no model for " << work_name(work);
    for (const std::string& thing : changeable_things()) {
      const bool can = std::any_of(candidates.models.begin(), candidates.models.end(),
                                   [&](const auto& model) { return model.cannot(work, {thing}).empty(); });
      // What a table or factors answer has to be made anew: nothing here keeps material and cuts there.
      EXPECT_EQ(can, work != FitWork::kFurther || thing == "supports") << work_name(work) << " " << thing;
    }
  }
  for (const FitStepping& stepping : candidates.steppings) {
    EXPECT_TRUE(labels.insert(stepping.label).second) << stepping.label << " twice";
    are_known(stepping.label, stepping.may_change);
    EXPECT_TRUE(stepping.cannot({"large_strain"}).empty()) << "a matter of models";
    const bool is_explicit = stepping.integrator == kExplicitIntegrator;
    for (const std::string& thing : changeable_things())
      EXPECT_EQ(stepping.cannot({thing}), is_explicit ? "" : thing) << stepping.label;
  }
}

TEST_F(FitPlans, ASteppingThatKeepsFactorsIsDroppedWhereTheyMayChange) {
  const std::string head =
      "schema: palpate/candidates/1\nsimplifiers: []\nmodels: [{label: m, method: smoothed.edge_node, works: "
      "{second: [supports]}}]\nsteppings:\n";
  const auto steppings = [&](const std::string& lines) { return read_text(head + lines).steppings; };
  std::vector<FitStepping> found = steppings(
      "  - {label: plain, integrator: symplectic_euler}\n"
      "  - {label: some, integrator: velocity_verlet, may_change: [material]}\n"
      "  - {label: factored, integrator: bdf2}\n"
      "  - {label: anew, integrator: vbd, may_change: [cuts, supports]}\n"
      "  - {label: modes, integrator: exponential, modes: 3}\n");
  EXPECT_EQ(found[0].may_change, changeable_things()) << "explicit steps ask the forces alone";
  EXPECT_THAT(found[2].may_change, testing::IsEmpty());
  EXPECT_THAT(found[4].may_change, testing::IsEmpty());
  std::vector<FitStepping> kept = found;
  std::vector<std::string> dropped;
  drop_steppings(kept, {"large_strain"}, dropped);
  EXPECT_EQ(kept.size(), 5U);
  EXPECT_THAT(dropped, testing::IsEmpty());
  drop_steppings(kept, {"large_strain", "supports"}, dropped);
  ASSERT_EQ(kept.size(), 2U);
  EXPECT_EQ(kept[0].label, "plain");
  EXPECT_EQ(kept[1].label, "anew");
  EXPECT_THAT(dropped, testing::ElementsAre("some (velocity_verlet steps) are not tried: they need a new "
                                            "set-up for a change of supports",
                                            HasSubstr("factored (bdf2 steps)")));
  const auto message = [&](const std::string& line) { return refusal_of(head + "  - " + line + "\n"); };
  EXPECT_THAT(message("{label: a, integrator: symplectic_euler, may_change: [support]}"),
              AllOf(HasSubstr("candidates.yaml:5:"), HasSubstr("did you mean \"supports\"?")));
  EXPECT_THAT(message("{label: a, integrator: symplectic_euler, may_change: [cuts, cuts]}"),
              HasSubstr("\"cuts\" twice"));
  EXPECT_THAT(message("{label: a, integrator: symplectic_euler, may_chance: [cuts]}"),
              HasSubstr("did you mean \"may_change\"?"));
}

TEST_F(FitPlans, BadCandidatesAreRefusedWithTheirPlace) {
  const auto message = [&](const std::string& model) {
    return refusal_of("schema: palpate/candidates/1\nsimplifiers: []\nmodels:\n  - " + model + "\n");
  };
  EXPECT_THAT(message("{label: a, method: smoothed.edgenode, works: {first: []}}"),
              AllOf(HasSubstr("candidates.yaml:4:"), HasSubstr("smoothed.edge_node")));
  EXPECT_THAT(message("{label: a, method: smoothed.edge_node, set: {thetta: 1}, works: {first: []}}"),
              HasSubstr("did you mean \"theta\"?"));
  EXPECT_THAT(message("{label: a, method: smoothed.edge_node, works: {fist: []}}"),
              HasSubstr("did you mean \"first\"?"));
  EXPECT_THAT(message("{label: a, method: smoothed.edge_node, works: {first: [cut]}}"),
              HasSubstr("did you mean \"cuts\"?"));
}

TEST_F(FitPlans, ASkinsBoundIsAShareOfTheBody) {
  const auto text_of = [](const std::string& simplifier) {
    return "schema: palpate/candidates/1\nsimplifiers:\n  - " + simplifier +
           "\nmodels: [{label: m, method: smoothed.edge_node, works: {first: []}}]\n";
  };
  const auto message = [&](const std::string& simplifier) { return refusal_of(text_of(simplifier)); };
  FitCandidates own =
      read_text(text_of("{label: a, method: palpate.surface, skin_within: 0.02, ratios: [0.5]}"));
  set_skin_bounds(own, 0.15);
  EXPECT_DOUBLE_EQ(own.simplifiers.front().set.at("max_surface_error_m").get<double>(), 0.003);
  EXPECT_THAT(message("{label: a, method: palpate.refined, skin_within: 0.02, ratios: [0.5]}"),
              AllOf(HasSubstr("candidates.yaml:3:"), HasSubstr("its skin has no bound")));
  EXPECT_THAT(message("{label: a, method: palpate.surface, skin_within: 0.2, ratios: [0.5]}"),
              HasSubstr("0.2"));
  EXPECT_THAT(message("{label: a, method: palpate.surface, set: {max_surface_error_m: 0.001}, skin_within: "
                      "0.02, ratios: [0.5]}"),
              HasSubstr("one bound"));
}

TEST_F(FitPlans, SimplifiersAreToldThatTheirMeshesAreInMillimetres) {
  const auto unit_of = [&](const char* method, const std::map<std::string, GivenOption>& given) {
    const nlohmann::json options = resolve_simplifier_options(*registry_.find(method)->method, given);
    return options.value("unit_m", -1.0);
  };
  EXPECT_DOUBLE_EQ(unit_of("palpate.surface", {}), 0.001);
  EXPECT_DOUBLE_EQ(unit_of("palpate.surface", {{"unit_m", {"0.5", "here"}}}), 0.5);
  EXPECT_DOUBLE_EQ(unit_of("palpate.refined", {}), -1.0);
}

TEST_F(FitPlans, AModelThatCannotDoItIsDroppedWithTheReason) {
  const FitCandidates candidates = read_text(
      "schema: palpate/candidates/1\n"
      "simplifiers: [{label: refined, method: palpate.refined, ratios: [0.5, 0.8]}]\n"
      "models:\n"
      "  - {label: able, method: smoothed.edge_node, works: {further: [supports]}}\n"
      "  - {label: stiff, method: smoothed.blend, works: {further: []}}\n"
      "  - {label: still, method: fem.p2, works: {first: [supports]}}\n");
  SceneRequirement require;
  require.needs = {"supports"};
  std::vector<std::string> dropped;
  const auto found = list_candidates(candidates, FitWork::kFurther, require, dropped);
  ASSERT_EQ(found.size(), 3U);  // as it is, and two shares
  EXPECT_EQ(found[0].name(), "able, the mesh as it is");
  EXPECT_EQ(found[2].name(), "able, refined -80%");
  EXPECT_THAT(dropped, testing::ElementsAre(HasSubstr("supports"), HasSubstr("the work \"further\"")));
}

TEST_F(FitPlans, AMovingSceneIsJudgedAtItsGreatestLoad) {
  test::SceneText text;
  text.mesh = "{make: bar, vertices: 100, length_m: 0.1}";
  text.load =
      "[{force: {sphere: {surface_point: {direction: [1, 0, 0]}, radius_m: 1}, total_n: [0, 0, 2]}, "
      "profile: {times_s: [0, 1, 2], shares: [0, -1.5, 1]}, until_s: 2}]";
  text.analysis = "{dynamic: {integrator: symplectic_euler, time_step_s: auto, duration_s: 3}}";
  text.rest = "model: {springs: van_gelder}\nrequire: {error: {measure: energy, at_most: 0.1}}\n";
  const Scene scene = read_scene(folder_.add("moving.yaml", text.yaml()));
  EXPECT_EQ(choose_work(scene), FitWork::kSecond);
  const json still = static_scene(scene);
  EXPECT_EQ(still.at("analysis"), "static");
  EXPECT_FALSE(still.contains("model"));
  EXPECT_FALSE(still.contains("require"));
  EXPECT_EQ(still.at("/load/0/force/total_n"_json_pointer), json({0.0, 0.0, -3.0}));
  EXPECT_FALSE(still.at("load")[0].contains("profile"));
  EXPECT_FALSE(still.at("load")[0].contains("until_s"));
}

TEST_F(FitPlans, EachCandidateIsOneCaseAScene) {
  test::SceneText text;
  text.mesh = "{make: bar, vertices: 100, length_m: 0.1}";
  text.rest = "require: {error: {measure: energy, at_most: 0.1}}\n";
  const Scene scene = read_scene(folder_.add("still.yaml", text.yaml()));
  const FitCandidates candidates = read_candidates(candidates_path(), registry_);
  FitPlan plan;
  plan.folder = folder_ / "fit";
  plan.enough = 0.01;
  plan.work = choose_work(scene);
  EXPECT_EQ(plan.work, FitWork::kFirst);
  plan.scenes = {static_scene(scene), perturbed_scene(static_scene(scene), 7)};
  std::vector<std::string> dropped;
  plan.candidates = list_candidates(candidates, plan.work, *scene.require, dropped);
  const Plan read = read_plan(write_fit_plan(plan, candidates), registry_);
  EXPECT_EQ(build_cases(read, registry_).size(), 2 * plan.candidates.size());
}

}  // namespace
}  // namespace palpate::experiments

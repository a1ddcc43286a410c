// The contest engine: plans, the three methods behind the door, the reference of the tool's force.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <map>

#include "core/base/error.h"
#include "core/mesh/io/medit.h"
#include "core/mesh/shapes/shapes.h"
#include "core/mesh/subdivision/refinement.h"
#include "core/mesh/topology.h"
#include "experiments/contests/pad_force.h"
#include "experiments/plan_reader/case_list.h"
#include "experiments/records/record_file.h"
#include "experiments/runner/contest_table.h"
#include "experiments/runner/read_plan.h"
#include "experiments/runner/runner.h"
#include "experiments/scene_reader/scene_problem.h"
#include "tests/support/experiment_fixture.h"
#include "tests/support/scene_text.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;
using test::SceneText;
using testing::ElementsAre;
using testing::HasSubstr;

/// Plans over "held" (a pad that stays) and "released" (a tool that lets go) on the fixture's cube of 0.1 m.
class EngineContest : public testing::Test {
 protected:
  EngineContest() {
    ::setenv("PALPATE_CACHE", (fixture_.folder() / "cache").c_str(), 1);
    SceneText text;
    text.rest = "strain: large\nmodel: {springs: van_gelder}\n";
    text.clamp = "[{half_space: {normal: [0, 0, 1], offset_m: 0}, elastic_pa_per_m: 1.0e6}]";
    text.load = pad("elastic_pa_per_m: 5.0e6", "");
    text.analysis = "{dynamic: " + dynamic("0.1") + "}";
    fixture_.folder().add("held.yaml", text.yaml());
    text.load = pad("elastic_pa_per_m: 5.0e6", ", until_s: 0.03");
    text.analysis = "{dynamic: " + dynamic("0.3") + "}";
    fixture_.folder().add("released.yaml", text.yaml());
  }
  ~EngineContest() override { ::unsetenv("PALPATE_CACHE"); }

  static std::string pad(const std::string& how, const std::string& rest) {
    return "[{displace: {half_space: {normal: [0, 0, -1], offset_m: -0.1}, by_m: [0, 0, -0.002]" +
           (how.empty() ? "" : ", " + how) +
           "}, profile: {times_s: [0, 0.02], shares: [0, 1], smooth: true}" + rest + "}]";
  }
  static std::string dynamic(const std::string& duration) {
    return "{integrator: symplectic_euler, time_step_s: auto, duration_s: " + duration +
           ", frames: 3, damping: {stiffness_s: 0.002, mass_per_s: 50}}";
  }

  std::filesystem::path add_plan(
      const std::string& contestants, const std::string& rest = "",
      const std::string& scenes =
          "[{name: held, file: held.yaml}, {name: released, file: released.yaml}]") const {
    return fixture_.folder().add(
        "plan.yaml", "schema: palpate/plan/1\nquestion: Does it come back?\ncontest: engine\nscenes: " +
                         scenes + "\ncontestants: " + contestants + "\n" + rest);
  }

  test::ExperimentFixture fixture_;
};

TEST_F(EngineContest, ScenesAreReplayedMeasuredAtRestAndTicked) {
  const auto plan = add_plan(
      "\n  - {method: engine.replay, label: replay, scenes: [released]}"
      "\n  - {method: engine.rest, label: rest}"
      "\n  - {method: engine.ticks, label: ticks, scenes: [held], set: {ticks: 100, precision: double}}",
      "sweep: {option.engine_threads: [1, 2]}\nrun: {repeats: 2}\n");
  const RunResult result = fixture_.run(plan);
  EXPECT_FALSE(result.required_rejected);
  EXPECT_FALSE(result.required_failed);
  const auto all = fixture_.records();
  ASSERT_EQ(all.size(), 5U);
  for (const auto& [id, record] : all) EXPECT_EQ(record.at("outcome"), "accepted") << id << record.dump();

  const json& replay = all.at("released/replay");
  const json& judged = replay.at("judge");
  EXPECT_GT(judged.at("return_error").get<double>(), 0.0);
  EXPECT_LT(judged.at("return_error").get<double>(), 0.05);
  EXPECT_GT(judged.at("twentieth_return_s").get<double>(), judged.at("half_return_s").get<double>());
  EXPECT_NEAR(replay.at("reported").at("tick_real_time_factor").get<double>(),
              replay.at("report").at("time_step_s").get<double>() / 5e-3, 1e-12);
  const json motion =
      json::parse(test::bytes_of(fixture_.folder() / "run" / replay.at("mesh_file").get<std::string>()));
  EXPECT_EQ(motion.at("columns").size(), motion.at("rows").at(5).size());
  EXPECT_EQ(motion.at("frames").size(), 4U);
  EXPECT_EQ(motion.at("frames").at(0).at("displacement_m").size(),
            3 * replay.at("mesh").at("vertices").get<std::size_t>());

  const json& rest = all.at("released/rest");
  EXPECT_NEAR(rest.at("reported").at("stability_margin").get<double>(), 1.0 / 0.9, 0.02);
  EXPECT_GT(rest.at("judge").at("slowest_decay_s").get<double>(), 0.0);
  EXPECT_NEAR(rest.at("judge").at("slowest_decay_s").get<double>(),
              rest.at("report").at("slowest_decay_s").get<double>(), 1e-12);

  const json& one = all.at("held/ticks/option.engine_threads=1");
  const json& two = all.at("held/ticks/option.engine_threads=2");
  EXPECT_EQ(one.at("output_hash"), two.at("output_hash"));
  const json& told = one.at("reported");
  EXPECT_EQ(told.at("ticks"), 100);
  EXPECT_LE(told.at("tick_p50_s").get<double>(), told.at("tick_worst_s").get<double>());
  // E A / l of the cube, and both pads in series, times the depth: half of it is 3.2 N.
  EXPECT_GT(one.at("judge").at("held_force_size_n").get<double>(), 0.5);
  EXPECT_LT(one.at("judge").at("held_force_size_n").get<double>(), 3.0);
  EXPECT_FALSE(one.at("judge").contains("force_error"));
  EXPECT_EQ(fixture_.run(plan, true).records_added, 0U);
}

/// A first phase that is over before half a step has none, and its state is the next one's first.
TEST_F(EngineContest, APhaseShorterThanHalfAStepAddsNoRow) {
  const auto add = [&](const char* name, const char* from) {
    SceneText text;
    text.rest = "strain: large\nmodel: {springs: van_gelder}\n";
    text.clamp = "[{half_space: {normal: [0, 0, 1], offset_m: 0}}]";
    text.load = pad("", std::string(", from_s: ") + from + ", until_s: 0.03");
    text.analysis =
        "{dynamic: {integrator: symplectic_euler, time_step_s: 1.0e-4, duration_s: 0.06, damping: "
        "{stiffness_s: 0.002, mass_per_s: 50}}}";
    fixture_.folder().add(std::string(name) + ".yaml", text.yaml());
  };
  add("early", "2.0e-5");
  add("on_step", "1.0e-4");
  fixture_.run(add_plan("[{method: engine.replay, label: replay}]", "",
                        "[{name: early, file: early.yaml}, {name: on_step, file: on_step.yaml}]"));
  for (const auto& [id, record] : fixture_.records())
    EXPECT_EQ(record.at("outcome"), "accepted") << id << record.dump();
}

TEST_F(EngineContest, OptionsOfOneContestantSweepItAlone) {
  const Plan plan = read_plan(
      add_plan("\n  - {method: engine.rest, label: a}\n  - {method: engine.replay, label: b, scenes: [held]}"
               "\n  - {method: engine.rest, label: c, set: {spring_damping: axial}, scenes: [released]}",
               "sweep: {option.spring_damping: [axial, isotropic]}\n"),
      fixture_.registry());
  std::vector<std::string> ids;
  for (const Case& each : build_cases(plan, fixture_.registry())) ids.push_back(each.id);
  EXPECT_THAT(ids, ElementsAre("held/a/option.spring_damping=axial", "held/a/option.spring_damping=isotropic",
                               "held/b", "released/a/option.spring_damping=axial",
                               "released/a/option.spring_damping=isotropic", "released/c"));
}

TEST_F(EngineContest, PlansThatMakeNoSenseAreRefusedWithTheirPlace) {
  const std::string good = "[engine.replay]";
  EXPECT_THAT(fixture_.error_of_plan(add_plan("[{method: engine.replay, scenes: [helt]}]")),
              HasSubstr("unknown scene \"helt\"; did you mean \"held\"?"));
  EXPECT_THAT(fixture_.error_of_plan(add_plan("[{method: engine.rest, set: {vertices: 100}}]")),
              HasSubstr("has its mesh from a file"));
  EXPECT_THAT(fixture_.error_of_plan(add_plan("[springs.uniform]")), HasSubstr("is in the contest deform"));
  EXPECT_THAT(fixture_.error_of_plan(add_plan(good, "simplify: [none]\n")),
              HasSubstr("belongs to the contest deform"));
  EXPECT_THAT(fixture_.error_of_plan(add_plan(good, "sweep: {vertices: [100]}\n")),
              HasSubstr("unknown sweep"));
  fixture_.folder().add("still.yaml", SceneText().yaml());
  EXPECT_THAT(fixture_.error_of_plan(add_plan(good, "", "[{name: still, file: still.yaml}]")),
              HasSubstr("is static; the contest engine takes dynamic ones"));
  EXPECT_THAT(fixture_.error_of_plan(add_plan(good, "", "[kidney_palpatio]")),
              HasSubstr("unknown scene \"kidney_palpatio\""));
  EXPECT_THAT(fixture_.error_of_plan(add_plan(good, "", "[]")), HasSubstr("at least one"));
  EXPECT_THAT(
      fixture_.error_of_plan(add_plan(good, "", "[{name: a, file: held.yaml}, {name: a, file: held.yaml}]")),
      HasSubstr("twice"));
}

TEST_F(EngineContest, WhatAMethodCannotDoIsBadInputInTheRecord) {
  fixture_.run(add_plan("[{method: engine.ticks, label: ticks, set: {ticks: 100}}]"));
  const auto all = fixture_.records();
  EXPECT_EQ(all.at("held/ticks").at("outcome"), "accepted");
  EXPECT_EQ(all.at("released/ticks").at("outcome"), "bad_input");
  EXPECT_THAT(all.at("released/ticks").at("message").get<std::string>(), HasSubstr("there all the time"));
}

TEST_F(EngineContest, AStepOverTheBoundIsSaid) {
  fixture_.run(add_plan(
      "[{method: engine.ticks, label: ticks, set: {ticks: 100, tick_s: 0.1, steps_per_tick: 1}, scenes: "
      "[held]}]"));
  const json record = fixture_.records().at("held/ticks");
  ASSERT_EQ(record.at("outcome"), "rejected") << record;
  EXPECT_EQ(record.at("report").at("outcome"), "diverged");
  EXPECT_GT(record.at("report").at("fewest_steps_per_tick"), 1);
  EXPECT_THAT(record.at("notes").dump(), HasSubstr("is over the bound at rest"));
}

TEST_F(EngineContest, AForceOfTheReferenceStandsBesideTheEngines) {
  const RunResult result =
      fixture_.run(add_plan("[{method: engine.ticks, label: ticks, set: {ticks: 100}, scenes: [held]}]",
                            "reference: {method: test.field}\n"));
  EXPECT_FALSE(result.required_failed);
  const auto all = fixture_.records();
  // The test's deformer answers without midpoints, so there is no force of it: that is said, and nothing else
  // is lost.
  EXPECT_EQ(all.at("held/reference").at("outcome"), "bad_answer");
  EXPECT_EQ(all.at("held/ticks").at("outcome"), "accepted");
  EXPECT_FALSE(all.at("held/ticks").at("judge").contains("force_error"));
}

/// The judge's figures of fem.p2 on two levels, for a pad with `region` that goes 10 mm into a cube of 0.1 m.
json judge_pad(const test::ExperimentFixture& fixture, const std::string& strain, double poisson_ratio,
               const std::string& region) {
  std::filesystem::remove_all(fixture.folder() / "run");
  write_medit(fixture.folder() / "coarse.mesh", build_kuhn_cube(2, 0.2, 3));
  SceneText text;
  text.mesh = "{file: coarse.mesh, length_m: 0.1}";
  text.material =
      "{young_modulus_pa: 10000, poisson_ratio: " + std::to_string(poisson_ratio) + ", density_kg_m3: 1000}";
  text.rest = "strain: " + strain + "\nmodel: {springs: van_gelder}\n";
  text.clamp = "[{half_space: {normal: [0, 0, 1], offset_m: 0}, elastic_pa_per_m: 1.0e6}]";
  text.load =
      "[{displace: {" + region +
      ", by_m: [0, 0, -0.01], elastic_pa_per_m: 5.0e6}, profile: {times_s: [0, 0.02], shares: [0, 1]}}]";
  text.analysis = "{dynamic: {integrator: symplectic_euler, time_step_s: auto, duration_s: 0.01}}";
  fixture.folder().add("pad.yaml", text.yaml());
  fixture.run(fixture.folder().add(
      "pad_plan.yaml",
      "schema: palpate/plan/1\nquestion: How hard?\ncontest: engine\nscenes: [{name: pad, file: pad.yaml}]\n"
      "reference: {method: fem.p2, levels: 2}\n"
      "contestants: [{method: engine.ticks, label: ticks, set: {ticks: 100}}]\n"));
  const json record = fixture.records().at("pad/reference");
  EXPECT_EQ(record.at("outcome"), "accepted") << record.dump();
  return record.at("judge");
}

const std::string kTop = "half_space: {normal: [0, 0, -1], offset_m: -0.1}";

// Without lateral contraction the cube is a bar between two beds of springs, and its field is linear:
// support, body and pad in series. In the large P = mu (s - 1 / s) at the stretch s.
TEST_F(EngineContest, TheForceOfAPadIsThatOfABarInClosedForm) {
  constexpr double kArea = 0.01;
  constexpr double kSide = 0.1;
  const double linear = 0.01 * kArea / (1.0 / 1e6 + kSide / 10000.0 + 1.0 / 5e6);
  double low = 0.0;  // force a unit of area
  double high = 0.01 * 1e6;
  for (int k = 0; k < 200; ++k) {
    const double pressure = 0.5 * (low + high);
    const double s = 1.0 - (0.01 - pressure / 1e6 - pressure / 5e6) / kSide;
    (5000.0 * (1.0 / s - s) > pressure ? low : high) = pressure;
  }
  for (const auto& [strain, size] : {std::pair{"small", linear}, std::pair{"large", low * kArea}}) {
    const json judged = judge_pad(fixture_, strain, 0.0, kTop);
    ASSERT_EQ(judged.at("level_reports").size(), 2U);
    for (const json& level : judged.at("level_reports")) {
      EXPECT_NEAR(level.at("force_n").at(2).get<double>(), -size, 1e-8 * size) << strain;
      EXPECT_NEAR(level.at("by_force_j").get<double>(), 0.01 * size, 1e-8 * size) << strain;
      EXPECT_NEAR(level.at("reaction_n").at(2).get<double>(), size, 1e-8 * size) << strain;
    }
    EXPECT_LT(judged.at("force_change").get<double>(), 1e-7);
  }
}

// Part of the face, and a body that bulges: no closed form, but energies that refinement can only lower.
TEST_F(EngineContest, RefinementLowersTheEnergyAndTheForceOfAPad) {
  for (const char* strain : {"small", "large"}) {
    const json judged =
        judge_pad(fixture_, strain, 0.3, "sphere: {center_m: [0.03, 0.03, 0.1], radius_m: 0.04}");
    const json& coarse = judged.at("level_reports").at(0);
    const json& fine = judged.at("level_reports").at(1);
    EXPECT_LT(fine.at("by_force_j").get<double>(), coarse.at("by_force_j").get<double>()) << strain;
    EXPECT_LT(fine.at("potential_j").get<double>(), coarse.at("potential_j").get<double>()) << strain;
    EXPECT_GT(judged.at("force_change").get<double>(), 1e-4) << strain;
    EXPECT_TRUE(judged.at("findings").empty());
  }
}

/// A problem of a pad alone, in small strain.
BoundaryProblem pad_alone() {
  BoundaryProblem problem;
  problem.supports.resize(2);
  problem.supports.back().by_m = {0.0, 0.0, -0.002};
  return problem;
}

PadLevel pad_level(double size_n, double potential_j) {
  return {{0.0, 0.0, -size_n}, {0.0, 0.0, size_n}, 0.002 * size_n, potential_j};
}

TEST(PadFaults, AreFoundWhereLevelsContradictMechanics) {
  BoundaryProblem problem = pad_alone();
  const std::vector<PadLevel> good{pad_level(0.555, 0.555e-3), pad_level(0.544, 0.544e-3)};
  EXPECT_TRUE(find_pad_faults(problem, good).empty());

  // A refined solution that is integrated as if it were a coarse one.
  std::vector<PadLevel> broken{good[0], pad_level(0.590, 0.544e-3)};
  broken[1].reaction_n = {0.0, 0.0, 0.544};
  const std::vector<std::string> faults = find_pad_faults(problem, broken);
  EXPECT_THAT(faults,
              ElementsAre(HasSubstr("level 1: the supports' reactions leave 0.046 N"),
                          HasSubstr("twice the energy of a linear body"), HasSubstr("raised by . F")));
  broken = {good[1], good[0]};
  EXPECT_THAT(find_pad_faults(problem, broken),
              ElementsAre(HasSubstr("raised the least energy"), HasSubstr("raised by . F")));
  broken = good;
  broken[0].potential_j = std::nan("");
  EXPECT_FALSE(find_pad_faults(problem, broken).empty());

  problem.strain = StrainSize::kLarge;  // by . F is then not twice the energy
  broken = {pad_level(0.6, 0.5e-3), pad_level(0.59, 0.49e-3)};
  EXPECT_TRUE(find_pad_faults(problem, broken).empty());
  problem.gravity_m_s2 = {0.0, 0.0, -9.81};  // and with a weight nothing of this is known
  EXPECT_TRUE(find_pad_faults(problem, {{good[1], good[0]}}).empty());
}

TEST(PadForce, IsExactForQuadraticFields) {
  const TetMesh mesh = build_kuhn_cube(2, 0.2, 3);
  ElasticSupport pad;
  pad.stiffness_pa_per_m = 100.0;
  pad.by_m = {0.0, 0.0, 2.0};
  for (const Face& face : build_faces(mesh)) {
    const auto [a, b, c] = face.vertices;
    const bool is_top = mesh.points[a].z == 1.0 && mesh.points[b].z == 1.0 && mesh.points[c].z == 1.0;
    if (face.tets[1] == kNoIndex && is_top) {
      pad.patch.faces.push_back(face.vertices);
      pad.patch.weight.push_back(0.5);
    }
  }
  const EdgeNumbers edges = build_edge_numbers(mesh);
  std::vector<Vec3> field;
  const auto at = [](const Vec3& x) { return Vec3{x.x * x.x, x.x * x.y, x.z}; };
  for (const Vec3& x : mesh.points) field.push_back(at(x));
  for (const auto& [a, b] : edges.edges) field.push_back(at(0.5 * (mesh.points[a] + mesh.points[b])));
  const Vec3 force = measure_pad_force(mesh, pad, field);
  EXPECT_NEAR(force.x, -50.0 / 3.0, 1e-12);
  EXPECT_NEAR(force.y, -50.0 / 4.0, 1e-12);
  EXPECT_NEAR(force.z, 50.0, 1e-12);
}

TEST_F(EngineContest, TheHeldProblemIsWhatTheProfilesLeave) {
  const auto held = [&](const std::string& load) {
    SceneText text;
    text.rest = "strain: large\nmodel: {springs: van_gelder}\n";
    text.clamp = "[{half_space: {normal: [0, 0, 1], offset_m: 0}, elastic_pa_per_m: 1.0e6}]";
    text.load = load;
    text.analysis = "{dynamic: " + dynamic("0.1") + "}";
    const Scene scene = read_scene(fixture_.folder().add("scene.yaml", text.yaml()));
    const TetMesh mesh = build_scene_mesh(scene.mesh).mesh;
    return build_held_problem(place_scene(scene, mesh), mesh);
  };
  const BoundaryProblem problem = held(pad("elastic_pa_per_m: 5.0e6", ""));
  ASSERT_EQ(problem.supports.size(), 2U);
  EXPECT_EQ(problem.supports.back().stiffness_pa_per_m, 5e6);
  EXPECT_EQ(problem.supports.back().by_m, (Vec3{0.0, 0.0, -0.002}));
  EXPECT_THROW(held(pad("", "")), InputError);
  EXPECT_THROW(held(pad("elastic_pa_per_m: 5.0e6", ", until_s: 0.03")), InputError);
  EXPECT_THROW(held("[{gravity_m_s2: [0, 0, -9.81]}]"), InputError);
}

}  // namespace
}  // namespace palpate::experiments

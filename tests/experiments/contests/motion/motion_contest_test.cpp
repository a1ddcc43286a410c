// The contest motion: from scene to problem, from plan to record, and what two motions of one problem differ
// by.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <map>

#include "core/base/error.h"
#include "experiments/contests/motion/motion_input.h"
#include "experiments/records/record_file.h"
#include "experiments/runner/read_plan.h"
#include "experiments/runner/runner.h"
#include "experiments/scene_reader/scene_problem.h"
#include "tests/support/angles.h"
#include "tests/support/experiment_fixture.h"
#include "tests/support/rod.h"
#include "tests/support/scene_text.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;
using test::kPi;
using test::Rod;
using test::SceneText;
using testing::HasSubstr;

/// The fixture's cube of 0.1 m on a pad, its top pulled and let go.
SceneText plucked(const std::string& dynamic = "") {
  SceneText text;
  text.material = "{young_modulus_pa: 10000, poisson_ratio: 0.25, density_kg_m3: 1000}";
  text.clamp = "[{half_space: {normal: [0, 0, 1], offset_m: 0}, elastic_pa_per_m: 1.0e6}]";
  text.load =
      "[{gravity_m_s2: [0, 0, -1]}, {displace: {half_space: {normal: [0, 0, -1], offset_m: -0.1}, by_m: "
      "[0.005, "
      "0, 0], elastic_pa_per_m: 5.0e6}, profile: {times_s: [0, 0.05], shares: [0, 1], smooth: true}, "
      "until_s: "
      "0.06}]";
  text.analysis =
      "{dynamic: {" +
      (dynamic.empty() ? "integrator: symplectic_euler, time_step_s: auto, duration_s: 0.2, probes_m: "
                         "[[0.1, 0.1, 0.1]], damping: {stiffness_s: 1.0e-3, mass_per_s: 2}"
                       : dynamic) +
      "}}";
  return text;
}

class MotionContest : public testing::Test {
 protected:
  MotionContest() { ::setenv("PALPATE_CACHE", (fixture_.folder() / "cache").c_str(), 1); }
  ~MotionContest() override { ::unsetenv("PALPATE_CACHE"); }

  reference::MotionProblem problem_of(const SceneText& text) const {
    const Scene scene = read_scene(fixture_.folder().add("block.yaml", text.yaml()));
    const TetMesh mesh = build_scene_mesh(scene.mesh).mesh;
    return build_compared_problem(place_scene(scene, mesh), mesh);
  }

  std::string error_of(const SceneText& text) const {
    try {
      problem_of(text);
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  }

  std::filesystem::path add_plan(
      const std::string& contestants, const std::string& rest = "",
      const std::string& reference = "{method: moving_fem.p1, levels: 2, set: {time_step_s: 4.0e-3}}") const {
    return fixture_.folder().add("plan.yaml",
                                 "schema: palpate/plan/1\nquestion: Does it swing?\ncontest: motion\n"
                                 "scenes: [{name: block, file: block.yaml}]\nreference: " +
                                     reference + "\ncontestants: " + contestants + "\n" + rest);
  }

  test::ExperimentFixture fixture_;
};

TEST_F(MotionContest, ASceneBecomesAProblemOfItsLoads) {
  const reference::MotionProblem problem = problem_of(plucked());
  EXPECT_EQ(problem.body.supports.size(), 1U);
  ASSERT_EQ(problem.loads.size(), 2U);
  EXPECT_EQ(problem.loads[0].part.gravity_m_s2, (Vec3{0, 0, -1}));
  EXPECT_FALSE(problem.loads[0].is_tool());
  EXPECT_TRUE(problem.loads[1].is_tool());
  EXPECT_EQ(problem.loads[1].part.gravity_m_s2, Vec3{});
  EXPECT_EQ(problem.loads[1].until_s, 0.06);
  EXPECT_EQ(problem.damping_stiffness_s, 1e-3);
  EXPECT_EQ(problem.probes.size(), 1U);
  EXPECT_EQ(judging_window(problem), (std::array{0.06, 0.2}));
}

TEST_F(MotionContest, WhatNotAllContestantsCanHaveIsRefused) {
  const std::string base =
      "integrator: symplectic_euler, time_step_s: auto, duration_s: 0.1, probes_m: [[0, 0, 0]]";
  EXPECT_THAT(error_of(plucked(base + ", damping: {spring_n_s_per_m: 1}")),
              HasSubstr("stiffness_s and mass_per_s"));
  EXPECT_THAT(error_of(plucked(base + ", damping: {vertex_n_s_per_m: 1}")),
              HasSubstr("stiffness_s and mass_per_s"));
  EXPECT_THAT(error_of(plucked(base + ", damping: {stiffness_s: 0.001, springs: isotropic}")),
              HasSubstr("axial"));
  EXPECT_THAT(error_of(plucked(base + ", mass_per_vertex_kg: 1")), HasSubstr("the material's masses"));
  EXPECT_THAT(error_of(plucked(base + ", speed_limit_m_s: 1")), HasSubstr("no speed limit"));
  EXPECT_THAT(error_of(plucked("integrator: symplectic_euler, time_step_s: auto, duration_s: 0.1")),
              HasSubstr("probes_m"));
  EXPECT_THAT(error_of(plucked("preset: thesis_table_4_1, duration_s: 0.1, probes_m: [[0, 0, 0]]")),
              HasSubstr("no preset"));
  SceneText large = plucked();
  large.rest = "strain: large\n";
  EXPECT_THAT(error_of(large), HasSubstr("small strain"));
}

TEST_F(MotionContest, AMotionOnASimplifiedMeshIsHeldAgainstTheWholeOne) {
  fixture_.folder().add("block.yaml", plucked().yaml());
  fixture_.run(add_plan("[{method: moving_springs.van_gelder, label: springs}]",
                        "simplify:\n  - none\n  - {method: test.copy, label: same, stop: {limit: true}}\n"
                        "  - {method: test.copy, label: lazy, stop: {ratio: 0.5}}\n"));
  const auto all = fixture_.records();
  const json& whole = all.at("block/springs/simplify=none");
  const json& same = all.at("block/springs/simplify=same");
  ASSERT_EQ(whole.at("outcome"), "accepted") << whole.dump();
  ASSERT_EQ(same.at("outcome"), "accepted") << same.dump();
  EXPECT_FALSE(whole.contains("solved_on"));
  EXPECT_EQ(same.at("/solved_on/tets"_json_pointer), whole.at("/mesh/tets"_json_pointer));
  EXPECT_GE(same.at("/solved_on/simplify_s"_json_pointer).get<double>(), 0.0);
  EXPECT_NEAR(same.at("/judge/probe_l2"_json_pointer).get<double>(),
              whole.at("/judge/probe_l2"_json_pointer).get<double>(), 1e-6);  // millimetres and back
  const json& lazy = all.at("block/springs/simplify=lazy");
  EXPECT_EQ(lazy.at("outcome"), "error");
  EXPECT_THAT(lazy.at("message").get<std::string>(), HasSubstr("no tetrahedra were removed"));
}

TEST_F(MotionContest, PlansThatMakeNoSense) {
  fixture_.folder().add("block.yaml", plucked().yaml());
  const std::string springs = "[moving_springs.van_gelder]";
  EXPECT_EQ(fixture_.error_of_plan(add_plan(springs)), "no error");
  EXPECT_THAT(fixture_.error_of_plan(add_plan("[springs.van_gelder]")), HasSubstr("contest"));
  EXPECT_THAT(fixture_.error_of_plan(add_plan(springs, "", "{method: fem.p2}")), HasSubstr("contest"));
  EXPECT_THAT(fixture_.error_of_plan(add_plan(springs, "", "{method: moving_springs.van_gelder}")),
              HasSubstr("refine"));
  EXPECT_THAT(fixture_.error_of_plan(add_plan(springs, "", "{method: moving_fem.p2, levels: 1}")),
              HasSubstr("2"));
  EXPECT_THAT(fixture_.error_of_plan(add_plan(springs, "", "{method: moving_fem.p2, enough: 0.1}")),
              HasSubstr("enough"));
  EXPECT_EQ(fixture_.error_of_plan(add_plan(springs, "simplify: [none]\n")), "no error");
  EXPECT_THAT(fixture_.error_of_plan(add_plan(springs, "sweep: {tets_removed_ratio: [0.5]}\n")),
              HasSubstr("needs the key \"simplify\""));
  EXPECT_THAT(fixture_.error_of_plan(add_plan(springs, "charts: [error_bars]\n")),
              HasSubstr("unknown chart"));
  EXPECT_THAT(fixture_.error_of_plan(add_plan(springs, "sweep: {tets: [100]}\n")),
              HasSubstr("unknown sweep"));
  EXPECT_THAT(fixture_.error_of_plan(add_plan("[{method: moving_springs.van_gelder, label: reference}]")),
              HasSubstr("the reference itself"));
  EXPECT_THAT(
      fixture_.error_of_plan(add_plan("[{method: moving_springs.van_gelder, set: {integrator: euler}}]")),
      HasSubstr("symplectic_euler"));
  fixture_.folder().add("block.yaml", SceneText().yaml());
  EXPECT_THAT(fixture_.error_of_plan(add_plan(springs)), HasSubstr("static"));
}

TEST_F(MotionContest, FromPlanToRecords) {
  fixture_.folder().add("block.yaml", plucked().yaml());
  const auto plan = add_plan(
      "[{method: moving_fem.p1, label: same, set: {refine: 1, time_step_s: 4.0e-3}}, {method: "
      "moving_smoothed.edge_node, label: smooth}, {method: moving_springs.van_gelder, label: too_long, set: "
      "{time_step_s: 1}}]");
  const auto folder = fixture_.folder() / "run";
  for (const bool resume : {false, true}) {
    RunOptions options;
    options.folder = folder;
    options.resume = resume;
    Progress progress(true);
    const RunResult result =
        run_plan(read_plan(plan, fixture_.registry()), fixture_.registry(), options, progress);
    EXPECT_EQ(result.records_added, resume ? 0U : 4U);
    EXPECT_TRUE(result.required_failed);
  }
  std::map<std::string, json> records;
  for (const json& record : read_records(folder / "records.jsonl")) records[record.at("label")] = record;
  ASSERT_EQ(records.size(), 4U);
  const json& own = records.at("reference").at("judge").at("own_error");
  EXPECT_EQ(records.at("reference").at("judge").at("runs").size(), 3U);
  EXPECT_EQ(records.at("reference").at("judge").at("frequencies_hz").size(), kComparedFrequencies);
  EXPECT_GT(own.at("probe_l2"), 0.0);
  EXPECT_GT(own.at("frequency_first"), 0.0);
  const json& same = records.at("same").at("judge");
  for (const char* name : {"probe_l2", "force_l2", "frequency_worst", "amplitude_error", "phase_error_deg"})
    EXPECT_NEAR(same.at(name), 0.0, 1e-6) << name;
  EXPECT_GT(records.at("smooth").at("judge").at("probe_l2"), 0.0);
  EXPECT_TRUE(std::filesystem::exists(folder / records.at("smooth").at("mesh_file").get<std::string>()));
  EXPECT_TRUE(std::filesystem::exists(folder / records.at("reference").at("mesh_file").get<std::string>()));
  EXPECT_EQ(records.at("too_long").at("outcome"), "bad_input");
  EXPECT_THAT(records.at("too_long").at("message").get<std::string>(), HasSubstr("stable step"));
}

TEST_F(MotionContest, ErrorsInClosedFormAndAnswersThatAreNone) {
  fixture_.folder().add("block.yaml", plucked().yaml());
  std::string contestants = "[{method: test.ringing, label: large, set: {factor: 1.1}}";
  for (const char* behave :
       {"diverge", "no_outcome", "no_file", "short_file", "no_frequencies", "few_frequencies"})
    contestants +=
        std::string(", {method: test.ringing, label: ") + behave + ", set: {behave: " + behave + "}}";
  const auto plan = add_plan(contestants + "]", "", "{method: test.ringing, levels: 2, set: {bias: 0.04}}");
  RunOptions options;
  options.folder = fixture_.folder() / "run";
  Progress progress(true);
  run_plan(read_plan(plan, fixture_.registry()), fixture_.registry(), options, progress);
  std::map<std::string, json> records;
  for (const json& record : read_records(options.folder / "records.jsonl"))
    records[record.at("label")] = record;
  // The truth is 1.01, the coarser level 1.04. The time step changes the rows alone: cubics through rows of 2
  // ms are off by 3 / 128 (60 / s x 2 ms)^4 = 5e-6 at most, of which a third counts.
  const double own = 1.04 / 1.01 - 1.0;
  EXPECT_NEAR(records.at("reference").at("judge").at("own_error").at("probe_l2"), own, 2e-6);
  const json& large = records.at("large").at("judge");
  for (const char* name : {"probe_l2", "force_l2", "amplitude_error"})
    EXPECT_NEAR(large.at(name), 1.1 / 1.01 - 1.0, 1e-6) << name;
  EXPECT_EQ(large.at("frequency_worst"), 0.0);
  EXPECT_EQ(records.at("diverge").at("outcome"), "rejected");
  EXPECT_THAT(records.at("diverge").at("message").get<std::string>(), HasSubstr("its outcome is diverged"));
  for (const auto& [label, reason] : {std::pair{"no_outcome", "no outcome"},
                                      {"no_file", "it completed and wrote no history"},
                                      {"short_file", "a history to 0.2 s"},
                                      {"no_frequencies", "10 frequencies in the report"},
                                      {"few_frequencies", "10 frequencies in the report"}}) {
    EXPECT_EQ(records.at(label).at("outcome"), "bad_answer") << label;
    EXPECT_THAT(records.at(label).at("message").get<std::string>(), HasSubstr(reason)) << label;
  }
}

/// A history of a rod with a pad from 0 to 1 s of 4 s: probe ringing at `hz`, force share(t).
JudgedMotion ringing(const reference::MotionProblem& problem, double hz, double decay, double size,
                     double force, int rows) {
  JudgedMotion motion{{reference::history_columns(problem), {}}, {1.0, hz}};
  for (int k = 0; k <= rows; ++k) {
    const double t = problem.duration_s * k / rows;
    const double probe = size * std::exp(-decay * t) * std::cos(2.0 * kPi * hz * t);
    motion.history.rows.push_back(
        {t, 0, 0, 0, 0, t <= 1.0 ? force * std::sin(kPi * t) : 0.0, 0, 0, probe, 0, 0});
  }
  return motion;
}

TEST(CompareMotions, FiguresOfSignalsInClosedForm) {
  Rod rod(1);
  reference::MotionLoad pad = rod.pad(1e4, 1e-3);
  pad.until_s = 1.0;
  rod.problem.loads = {pad};
  rod.problem.duration_s = 4.0;
  const JudgedMotion truth = ringing(rod.problem, 2.0, 0.5, 1e-3, 1.0, 4000);
  const json same = compare_motions(rod.problem, ringing(rod.problem, 2.0, 0.5, 1e-3, 1.0, 1600), truth);
  EXPECT_LT(same.at("probe_l2"), 1e-6);
  EXPECT_LT(same.at("force_l2"), 1e-5) << "other times of samples, and a force that ends between them";
  const json off = compare_motions(rod.problem, ringing(rod.problem, 2.1, 0.6, 1.2e-3, 0.9, 3000), truth);
  EXPECT_NEAR(off.at("force_l2"), 0.1, 1e-5);
  EXPECT_NEAR(off.at("oscillation_error"), 0.05, 1e-6);
  EXPECT_NEAR(off.at("decay_error"), 0.2, 1e-5);
  EXPECT_NEAR(off.at("amplitude_error"), 1.2 * std::exp(-0.1) - 1.0, 1e-6)
      << "where the window starts, at 1 s";
  EXPECT_NEAR(off.at("phase_error_deg"), 36.0, 1e-3) << "a twentieth of two turns";
  EXPECT_NEAR(off.at("frequency_worst"), 0.05, 1e-12);
  EXPECT_EQ(off.at("frequency_first"), 0.0);
  EXPECT_NEAR(off.at("frequency_mean"), 0.025, 1e-12);
  EXPECT_LT(off.at("unexplained"), 1e-6);
}

// A probe that jerks about has no amplitude and no phase: what is left over says so, and the rest stays.
TEST(CompareMotions, WhatDoesNotOscillateIsNotComparedAsIfItDid) {
  Rod rod(1);
  rod.problem.loads = {};
  rod.problem.duration_s = 4.0;
  const auto motion = [&](const auto& probe) {
    JudgedMotion made{{reference::history_columns(rod.problem), {}}, {1.0}};
    for (int k = 0; k <= 800; ++k) {
      const double t = rod.problem.duration_s * k / 800;
      made.history.rows.push_back({t, 0, 0, 0, 0, probe(t), 0, 0});
    }
    return made;
  };
  const auto ring = motion([](double t) { return 1e-3 * std::cos(2.0 * kPi * 2.0 * t); });
  const auto jerk = motion([](double t) { return 1e-3 * std::cos(2.0 * kPi * (2.0 + 9.0 * t) * t); });
  for (const auto& [found, truth] : {std::pair{jerk, ring}, std::pair{ring, jerk}}) {
    const json figures = compare_motions(rod.problem, found, truth);
    EXPECT_FALSE(figures.contains("amplitude_error")) << figures.dump();
    EXPECT_FALSE(figures.contains("phase_error_deg"));
    EXPECT_TRUE(figures.contains("unexplained"));
    EXPECT_GT(figures.at("probe_l2"), 0.1);
  }
  EXPECT_TRUE(compare_motions(rod.problem, ring, ring).contains("amplitude_error"));
}

TEST(JudgingWindow, OfLoadsThatNeverRestIsTheSecondHalf) {
  Rod rod(1);
  reference::MotionLoad pad = rod.pad(1e4, 1e-3);
  pad.profile = {{0.0, 0.5, 1.0}, {0.0, 1.0, 0.0}, true};
  rod.problem.loads = {pad};
  rod.problem.duration_s = 1.0;
  EXPECT_EQ(judging_window(rod.problem), (std::array{0.5, 1.0}));
  rod.problem.duration_s = 2.0;
  EXPECT_EQ(judging_window(rod.problem), (std::array{1.0, 2.0}));
}

}  // namespace
}  // namespace palpate::experiments

// The contest deform from plan to record, with a contestant whose field is known.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <map>

#include "core/base/error.h"
#include "core/mesh/io/medit.h"
#include "core/mesh/topology.h"
#include "experiments/plan_reader/case_list.h"
#include "experiments/records/record_file.h"
#include "experiments/runner/contest_table.h"
#include "experiments/runner/read_plan.h"
#include "experiments/runner/runner.h"
#include "reference/door/deform_problem.h"
#include "tests/support/experiment_fixture.h"
#include "tests/support/scene_text.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;
using test::SceneText;
using testing::HasSubstr;

/// Plans over the scene "block", the fixture's cube of 0.1 m; answers are kept in a cache of the test's own.
class DeformRun : public testing::Test {
 protected:
  DeformRun() {
    ::setenv("PALPATE_CACHE", (fixture_.folder() / "cache").c_str(), 1);
    fixture_.folder().add("block.yaml", SceneText().yaml());
  }
  ~DeformRun() override { ::unsetenv("PALPATE_CACHE"); }

  std::filesystem::path add_plan(const std::string& contestants, const std::string& rest = "",
                                 const std::string& reference = "{method: test.field}") const {
    return fixture_.folder().add("plan.yaml",
                                 "schema: palpate/plan/1\nquestion: Does it bend?\ncontest: deform\n"
                                 "scenes: [{name: block, file: block.yaml}]\nreference: " +
                                     reference + "\ncontestants: " + contestants + "\n" + rest);
  }

  test::ExperimentFixture fixture_;
};

/// Times are those that the answers report. `slow` is twenty times as slow as `quick` of its family and
/// worse: after three repeats it gets no more. `other` is slow and as bad, but alone in its family; `good` is
/// slow and better than all.
TEST_F(DeformRun, HalvingLeavesOutWhatCannotBeOnTheFrontier) {
  const auto plan = add_plan(
      "\n  - {method: test.field, label: quick, set: {factor: 0.95}}"
      "\n  - {method: test.field, label: slow, set: {factor: 0.9, takes_s: 2.0e-5}}"
      "\n  - {method: test.field, label: good, set: {factor: 0.99, takes_s: 1.0e-5}}"
      "\n  - {method: test.field, label: other, set: {factor: 0.9, takes_s: 1.0e-5}}",
      "run: {repeats: 8, warmup: 1, halving_from: 3}\n"
      "frontier: {families: {ours: [quick, slow, good], theirs: [other]}, against: [theirs], at: [0.1]}\n",
      "{method: test.field, levels: 2}");
  const auto count = [&] {
    std::map<std::string, int> repeats;
    for (const json& record : read_records(fixture_.folder() / "run/records.jsonl"))
      ++repeats[record.at("label").get<std::string>()];
    return repeats;
  };
  fixture_.run(plan);
  const std::map<std::string, int> expected{
      {"reference", 1}, {"quick", 9}, {"slow", 4}, {"good", 9}, {"other", 9}};
  EXPECT_EQ(count(), expected);
  std::ifstream file(fixture_.folder() / "run/provenance.json");
  const json provenance = json::parse(file);
  EXPECT_EQ(provenance.at("repeats_ended"),
            json::parse(
                R"({"block/slow": {"reason": "halved", "repeats": 3, "width": null, "by": "block/quick"}})"));
  EXPECT_EQ(provenance.at("repeats_of"), json({{"block/slow", 3}}));
  EXPECT_TRUE(fixture_.run(plan, true).is_whole);
  EXPECT_EQ(count(), expected) << "gone on with, the same is left out";
}

TEST_F(DeformRun, AnInterruptWhileMeshesAreMadeLeavesNoneToTheRestAndItGoesOn) {
  const auto plan = add_plan("[{method: test.field, label: off}]",
                             "simplify: [{method: test.copy, label: copied, stop: {limit: true}}]\n");
  const volatile std::sig_atomic_t raised = 1;
  const Plan read = read_plan(plan, fixture_.registry());
  RunOptions options;
  options.folder = fixture_.folder() / "run";
  options.stop_flag = &raised;
  Progress progress(true);
  const RunResult result = run_plan(read, fixture_.registry(), options, progress);
  EXPECT_TRUE(result.interrupted);
  EXPECT_FALSE(std::filesystem::exists(fixture_.folder() / "run/records.jsonl"));
  EXPECT_TRUE(fixture_.run(plan, true).is_whole);
  EXPECT_EQ(fixture_.records().at("block/off/simplify=copied").at("outcome"), "accepted");
}

TEST_F(DeformRun, AnErrorOfATenthIsFoundToBeOne) {
  const auto plan = add_plan(
      "\n  - {method: test.field, label: exact}\n  - {method: test.field, label: stiff, set: {factor: 0.9}}"
      "\n  - {method: test.field, label: quadratic, set: {factor: 1.1, midpoints: true}}",
      "sweep: {poisson_ratio: [0.25, 0.45]}\n");
  const RunResult result = fixture_.run(plan);
  EXPECT_FALSE(result.required_rejected);
  EXPECT_FALSE(result.required_failed);
  const auto all = fixture_.records();
  for (const char* ratio : {"0.25", "0.45"}) {
    const std::string end = std::string("/poisson_ratio=") + ratio;
    EXPECT_EQ(all.at("block/exact" + end).at("judge").at("displacement_l2"), 0.0);
    for (const char* label : {"block/stiff", "block/quadratic"}) {
      const json& record = all.at(label + end);
      EXPECT_EQ(record.at("outcome"), "accepted") << record.dump();
      for (const char* key : {"displacement_l2", "displacement_deformation", "displacement_max",
                              "displacement_energy", "displacement_energy_whole"})
        EXPECT_NEAR(record.at("judge").at(key).get<double>(), 0.1, 1e-12) << key;
      EXPECT_EQ(record.at("scene").at("poisson_ratio"), json::parse(ratio));
      EXPECT_EQ(record.at("stop"), json());
      EXPECT_TRUE(
          std::filesystem::exists(fixture_.folder() / "run" / record.at("mesh_file").get<std::string>()));
    }
    EXPECT_EQ(all.at("block/reference" + end).at("judge").at("levels"), 2);
  }
}

TEST_F(DeformRun, TheReferenceIsExtrapolatedAndJudgesItself) {
  // Levels are off by 0.08, 0.02 and 0.005: of second order, so that the extrapolated field is exact.
  const auto plan = add_plan("[{method: test.field, label: off, set: {factor: 1.1}}]", "",
                             "{method: test.field, levels: 3, set: {bias: 0.08}}");
  fixture_.run(plan);
  const auto all = fixture_.records();
  const json& reference = all.at("block/reference").at("judge");
  EXPECT_EQ(reference.at("kind"), "extrapolated");
  EXPECT_EQ(reference.at("levels"), 3);
  EXPECT_NEAR(reference.at("order").get<double>(), 2.0, 1e-9);
  const json& figures = all.at("block/off").at("judge");
  EXPECT_NEAR(figures.at("displacement_l2").get<double>(), 0.1, 1e-12);
  const double own = figures.at("reference_error").get<double>();
  EXPECT_GT(own, 0.0);
  EXPECT_NEAR(figures.at("reference_ratio").get<double>(), 0.1 / own, 1e-9);
  EXPECT_EQ(figures.at("reference_too_coarse"), own > 0.1 / 5.0);
}

// Another program can judge again from the run folder alone.
TEST_F(DeformRun, TheFieldThatIsJudgedByIsKeptWithTheRun) {
  fixture_.run(add_plan("[{method: test.field, label: off, set: {factor: 1.1}}]", "",
                        "{method: test.field, levels: 3, set: {bias: 0.08}}"));
  const auto all = fixture_.records();
  const auto file = fixture_.folder() / "run" / all.at("block/reference").at("mesh_file").get<std::string>();
  const auto rows = all.at("block/off").at("mesh").at("vertices").get<std::size_t>();
  const TetMesh mesh = read_medit(fixture_.folder() / "run/problems/block/in.mesh").mesh;
  const std::vector<Vec3> kept = reference::read_displacement(file, rows, build_edges(mesh).size());
  ASSERT_EQ(kept.size(), rows + build_edges(mesh).size());
  const auto answer = fixture_.folder() / "run" / all.at("block/off").at("mesh_file").get<std::string>();
  const std::vector<Vec3> given = reference::read_displacement(answer, rows, build_edges(mesh).size());
  for (std::size_t i = 0; i < rows; ++i) EXPECT_LE(length(given[i] - 1.1 * kept[i]), 1e-12);
}

// A linear field times 1 + d pulls by d times the integral of k u less: twice the d, twice the error.
TEST_F(DeformRun, ThePadsForceIsHeldAgainstTheReferencesOwn) {
  SceneText pressed;
  pressed.load =
      "[{displace: {half_space: {normal: [0, 0, -1], offset_m: -0.1}, by_m: [0, 0, -0.005], "
      "elastic_pa_per_m: 1.0e6}}]";
  fixture_.folder().add("block.yaml", pressed.yaml());
  fixture_.run(add_plan(
      "\n  - {method: test.field, label: exact}\n  - {method: test.field, label: near, set: {factor: 1.1}}"
      "\n  - {method: test.field, label: far, set: {factor: 1.2, midpoints: true}}"));
  const auto all = fixture_.records();
  const auto error = [&](const std::string& label) {
    return all.at("block/" + label).at("judge").at("pad_force").get<double>();
  };
  EXPECT_NEAR(error("exact"), 0.0, 1e-12);
  EXPECT_GT(error("near"), 0.01);
  EXPECT_NEAR(error("far"), 2.0 * error("near"), 1e-12);
  const json& reference = all.at("block/reference").at("judge");
  EXPECT_EQ(reference.at("pad_forces_n").size(), 1U) << "the support does not move";
  EXPECT_EQ(reference.at("reference_error_pad_force"), 0.0) << "both levels are the same";
}

// Two loads of one body on one support: the first one's processes solve the second along, level by level. A
// third scene of another material is on its own.
TEST_F(DeformRun, ReferencesOfOneStiffnessAreSolvedTogether) {
  SceneText other;
  other.load = "[{gravity_m_s2: [0, 3, 0]}]";
  fixture_.folder().add("other.yaml", other.yaml());
  other.material = "{young_modulus_pa: 9999, poisson_ratio: 0.25, density_kg_m3: 1000}";
  fixture_.folder().add("soft.yaml", other.yaml());
  const auto plan = fixture_.folder().add(
      "plan.yaml",
      "schema: palpate/plan/1\nquestion: Does it bend?\ncontest: deform\nscenes: [{name: block, file: "
      "block.yaml}, {name: other, file: other.yaml}, {name: soft, file: soft.yaml}]\n"
      "reference: {method: test.field, levels: 2}\ncontestants: [test.field]\n");
  fixture_.run(plan);
  const auto all = fixture_.records();
  const auto is_kept = [&](const char* scene, std::size_t level) {
    return all.at(std::string(scene) + "/reference")
        .at("judge")
        .at("level_reports")
        .at(level)
        .at("from_cache")
        .get<bool>();
  };
  for (const std::size_t level : {0U, 1U}) {
    EXPECT_FALSE(is_kept("block", level));
    EXPECT_TRUE(is_kept("other", level));
    EXPECT_FALSE(is_kept("soft", level));
  }
  EXPECT_FALSE(
      all.at("block/reference").at("judge").at("level_reports").at(0).at("report").contains("further"));
  EXPECT_EQ(all.at("other/test.field").at("judge").at("displacement_l2"), 0.0);
}

// Whether a third level is asked for, each load's own second one tells: those that need it are solved along.
TEST_F(DeformRun, AThirdLevelIsSolvedAlongWhereItIsAskedFor) {
  SceneText other;
  other.load = "[{gravity_m_s2: [0, 3, 0]}]";
  fixture_.folder().add("other.yaml", other.yaml());
  const auto run = [&](const std::string& enough) {
    std::filesystem::remove_all(fixture_.folder() / "run");
    fixture_.run(fixture_.folder().add(
        "plan.yaml",
        "schema: palpate/plan/1\nquestion: Does it bend?\ncontest: deform\nscenes: [{name: block, file: "
        "block.yaml}, {name: other, file: other.yaml}]\n"
        "reference: {method: test.field, levels: 3, enough: " +
            enough + ", set: {bias: 0.08}}\ncontestants: [test.field]\n"));
    return fixture_.records().at("other/reference").at("judge").at("level_reports");
  };
  EXPECT_EQ(run("0.07").size(), 2U) << "|0.08 - 0.02| is below 0.07";
  const json levels = run("0.01");
  ASSERT_EQ(levels.size(), 3U);
  EXPECT_EQ(levels.at(2).at("from_cache"), true) << "the first load's process has solved it";
  EXPECT_EQ(fixture_.records().at("block/reference").at("judge").at("level_reports").at(2).at("from_cache"),
            false);
}

TEST_F(DeformRun, ARowWhoseReferenceIsTooCoarseIsMarked) {
  fixture_.run(add_plan(
      "[{method: test.field, label: off, set: {factor: 1.01}}, {method: test.field, label: far, set: "
      "{factor: 3}}]",
      "", "{method: test.field, levels: 2, set: {bias: 0.08}}"));
  const auto all = fixture_.records();
  EXPECT_EQ(all.at("block/off").at("judge").at("reference_too_coarse"), true);
  EXPECT_EQ(all.at("block/off").at("outcome"), "accepted") << "marked, not refused";
  EXPECT_EQ(all.at("block/far").at("judge").at("reference_too_coarse"), false);
}

TEST_F(DeformRun, AReferenceThatIsGoodEnoughRefinesNoFurther) {
  fixture_.run(
      add_plan("[test.field]", "", "{method: test.field, levels: 4, enough: 0.07, set: {bias: 0.08}}"));
  EXPECT_EQ(fixture_.records().at("block/reference").at("judge").at("levels"), 2)
      << "|0.08 - 0.02| is below 0.07";
}

TEST_F(DeformRun, ReferencesAreSolvedOnceAndKept) {
  const auto plan = add_plan("[test.field]");
  fixture_.run(plan);
  const json first = fixture_.records().at("block/reference");
  EXPECT_EQ(first.at("judge").at("level_reports").at(0).at("from_cache"), false);
  std::filesystem::remove_all(fixture_.folder() / "run");
  fixture_.run(plan);
  const json second = fixture_.records().at("block/reference");
  EXPECT_EQ(second.at("judge").at("level_reports").at(1).at("from_cache"), true);
  EXPECT_EQ(second.at("judge").at("max_displacement_m"), first.at("judge").at("max_displacement_m"));
  // Another stiffness is another problem: nothing that was kept answers it.
  SceneText softer;
  softer.material = "{young_modulus_pa: 9999, poisson_ratio: 0.25, density_kg_m3: 1000}";
  fixture_.folder().add("block.yaml", softer.yaml());
  std::filesystem::remove_all(fixture_.folder() / "run");
  fixture_.run(plan);
  EXPECT_EQ(fixture_.records().at("block/reference").at("judge").at("level_reports").at(0).at("from_cache"),
            false);
}

TEST_F(DeformRun, DamagedAnswersInTheCacheAreMadeAgain) {
  const auto plan = add_plan("[test.field]", "", "{method: test.field, levels: 1}");
  fixture_.run(plan);
  std::size_t spoilt = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(fixture_.folder() / "cache")) {
    if (entry.path().filename() != "displacement.csv") continue;
    std::ofstream(entry.path(), std::ios::app) << "garbage\n";
    ++spoilt;
  }
  ASSERT_EQ(spoilt, 1U);
  std::filesystem::remove_all(fixture_.folder() / "run");
  fixture_.run(plan);
  const json record = fixture_.records().at("block/reference");
  EXPECT_EQ(record.at("judge").at("level_reports").at(0).at("from_cache"), false);
}

TEST_F(DeformRun, NumericalOutcomesAreDataAndBrokenAnswersAreNot) {
  const std::map<std::string, std::pair<std::string, std::string>> expected{
      {"diverge", {"rejected", "its outcome is diverged"}},
      {"no_outcome", {"bad_answer", "its report has no outcome"}},
      {"no_file", {"bad_answer", "it converged and wrote no displacement"}},
      {"short_file", {"bad_answer", "its displacement cannot be read"}},
      {"nan_file", {"bad_answer", "its displacement cannot be read"}},
      {"refuse", {"bad_input", "not this problem"}}};
  std::string contestants;
  for (const auto& [behave, outcome] : expected)
    contestants += "\n  - {method: test.field, label: " + behave + ", set: {behave: " + behave + "}}";
  const RunResult result = fixture_.run(add_plan(contestants));
  EXPECT_TRUE(result.required_rejected);
  EXPECT_TRUE(result.required_failed);
  const auto all = fixture_.records();
  for (const auto& [behave, outcome] : expected) {
    const json& record = all.at("block/" + behave);
    EXPECT_EQ(record.at("outcome"), outcome.first) << behave;
    EXPECT_THAT(record.at("message").get<std::string>(), HasSubstr(outcome.second)) << behave;
    EXPECT_EQ(record.at("output_hash"), json()) << behave;
  }
  EXPECT_EQ(all.at("block/diverge").at("report").at("outcome"), "diverged");
}

TEST_F(DeformRun, WithoutAReferenceNothingIsJudged) {
  const RunResult result =
      fixture_.run(add_plan("[test.field]", "", "{method: test.field, levels: 1, set: {behave: diverge}}"));
  EXPECT_TRUE(result.required_failed);
  const auto all = fixture_.records();
  EXPECT_EQ(all.at("block/reference").at("outcome"), "error");
  EXPECT_THAT(all.at("block/test.field").at("message").get<std::string>(),
              HasSubstr("nothing to judge it by: level 0 of the reference ended with the outcome diverged"));
}

TEST_F(DeformRun, SimplifiedMeshesAreJudgedOnTheScenesOwnVertices) {
  const auto plan =
      add_plan("[{method: test.field, label: off, set: {factor: 1.1}}]",
               "simplify: [none, {method: test.copy, label: copied, stop: {limit: true}}, {method: "
               "test.copy, label: cut, set: {behave: drop_tet}}]\nsweep: {tets_removed_ratio: [0.2]}\n");
  fixture_.run(plan);
  const auto all = fixture_.records();
  EXPECT_EQ(all.count("block/off/simplify=none"), 1U);
  EXPECT_FALSE(all.at("block/off/simplify=none").contains("solved_on"));
  const json& copied = all.at("block/off/simplify=copied");
  EXPECT_EQ(copied.at("outcome"), "accepted") << copied.dump();
  EXPECT_NEAR(copied.at("judge").at("displacement_l2").get<double>(), 0.1, 1e-12);
  EXPECT_EQ(copied.at("judge").at("points_outside"), 0);
  EXPECT_EQ(copied.at("solved_on").at("vertices"), copied.at("mesh").at("vertices"));
  const json& cut = all.at("block/off/simplify=cut/tets_removed_ratio=0.2");
  EXPECT_EQ(cut.at("solved_on").at("tets").get<int>() + 1, cut.at("mesh").at("tets").get<int>());
}

TEST_F(DeformRun, AMeshThatASimplifierLeftAsItIsDoesNotCountAsSimplified) {
  const auto plan =
      add_plan("[{method: test.field, label: off}]",
               "simplify: [{method: test.copy, label: lazy}]\nsweep: {tets_removed_ratio: [0.2]}\n");
  fixture_.run(plan);
  const json record = fixture_.records().at("block/off/simplify=lazy/tets_removed_ratio=0.2");
  EXPECT_EQ(record.at("outcome"), "error") << record.dump();
  EXPECT_THAT(record.at("message").get<std::string>(), HasSubstr("no tetrahedra were removed"));
}

TEST_F(DeformRun, CasesCrossProblemsOptionsAndSimplifiers) {
  const auto path =
      add_plan("\n  - test.field\n  - {method: test.field, label: b, set: {factor: 2}}",
               "simplify: [none, {method: test.copy, label: c}]\nsweep: {poisson_ratio: [0.25], "
               "tets_removed_ratio: [0.2, 0.4], option.factor: [1, 3]}\n");
  const Plan plan = read_plan(path, fixture_.registry());
  std::vector<std::string> ids;
  for (const Case& c : build_cases(plan, fixture_.registry())) ids.push_back(c.id);
  EXPECT_EQ(ids.size(), 9U);
  EXPECT_EQ(ids.front(), "block/test.field/option.factor=1/poisson_ratio=0.25/simplify=none");
  EXPECT_EQ(ids.back(), "block/b/poisson_ratio=0.25/simplify=c/tets_removed_ratio=0.4");
}

TEST_F(DeformRun, ResumesAndHoldsProblemsAgainstTheirHashes) {
  const auto plan = add_plan("\n  - {method: test.field, label: a}\n  - {method: test.field, label: b}");
  fixture_.run(plan, false, "block/a");
  EXPECT_EQ(fixture_.records().count("block/b"), 0U);
  const RunResult second = fixture_.run(plan, true);
  EXPECT_EQ(second.records_added, 1U);
  EXPECT_EQ(fixture_.records().count("block/b"), 1U);
  SceneText other;
  other.load = "[{gravity_m_s2: [0, 0, -1]}]";
  fixture_.folder().add("block.yaml", other.yaml());
  EXPECT_THROW(fixture_.run(plan, true), InputError) << "the scene is another one now";
}

TEST_F(DeformRun, PlansThatAreWrong) {
  EXPECT_THAT(fixture_.error_of_plan(add_plan("[test.field]", "meshes: [{name: a, make: bar}]\n")),
              HasSubstr("plan.yaml:7: \"meshes\" belongs to the contest simplify"));
  EXPECT_THAT(fixture_.error_of_plan(add_plan("[test.copy]")),
              HasSubstr("is in the contest simplify, not in deform"));
  EXPECT_THAT(fixture_.error_of_plan(add_plan("[{method: test.field, stop: {limit: true}}]")),
              HasSubstr("stops belong to"));
  EXPECT_THAT(fixture_.error_of_plan(add_plan("[{method: test.field, label: reference}]")),
              HasSubstr("the reference itself"));
  EXPECT_THAT(fixture_.error_of_plan(add_plan("[test.field]", "", "{method: test.unrefined}")),
              HasSubstr("option \"refine\""));
  EXPECT_THAT(fixture_.error_of_plan(add_plan("[test.field]", "", "{method: test.field, set: {refine: 1}}")),
              HasSubstr("follows from"));
  EXPECT_THAT(fixture_.error_of_plan(add_plan("[test.field]", "sweep: {poisson_ratio: [0.5]}\n")),
              HasSubstr("below 0.5"));
  EXPECT_THAT(fixture_.error_of_plan(add_plan("[test.field]", "sweep: {poison_ratio: [0.4]}\n")),
              HasSubstr("did you mean"));
  EXPECT_THAT(fixture_.error_of_plan(add_plan("[test.field]", "sweep: {vertices: [500]}\n")),
              HasSubstr("has its mesh from a file"));
  EXPECT_THAT(fixture_.error_of_plan(add_plan("[test.field]", "sweep: {tets_removed_ratio: [0.5]}\n")),
              HasSubstr("\"simplify\""));
  const auto scenes = fixture_.folder().add(
      "scenes.yaml",
      "schema: palpate/plan/1\nquestion: q\ncontest: deform\nscenes: [bar_tensoin]\nreference: {method: "
      "test.field}\ncontestants: [test.field]\n");
  EXPECT_THAT(fixture_.error_of_plan(scenes), HasSubstr("did you mean \"bar_tension\"?"));
  SceneText dynamic;
  dynamic.analysis = "{dynamic: {integrator: velocity_verlet, time_step_s: 0.1, duration_s: 1}}";
  fixture_.folder().add("block.yaml", dynamic.yaml());
  EXPECT_THAT(fixture_.error_of_plan(add_plan("[test.field]")),
              HasSubstr("is dynamic; the contest deform takes static ones"));
}

}  // namespace
}  // namespace palpate::experiments

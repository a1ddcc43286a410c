#include "experiments/runner/runner.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "core/mesh/io/medit.h"
#include "core/mesh/shapes/shapes.h"
#include "experiments/records/record_file.h"
#include "experiments/rounds/round_order.h"
#include "experiments/runner/contest_table.h"
#include "experiments/runner/read_plan.h"
#include "tests/support/experiment_fixture.h"
#include "tests/support/quiet_run.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;
using test::records_by_case;
using test::run_quietly;
using testing::HasSubstr;

TEST(Runner, RecordsEveryRepeatInRounds) {
  const test::ExperimentFixture fixture;
  const auto plan =
      fixture.add_plan("\n  - test.copy\n  - {method: test.copy, label: seeded, seeds: 2}",
                       "run: {repeats: 2, warmup: 1}\naccept: {boundary_changed_faces: {max: 0}}\n");
  const auto folder = fixture.folder() / "run";
  const RunResult result = run_quietly(fixture, plan, folder);
  EXPECT_FALSE(result.required_failed);
  EXPECT_FALSE(result.required_rejected);
  std::vector<std::string> order;
  std::vector<std::string> expected{"cube/input#0"};
  const Plan read = read_plan(plan, fixture.registry());
  const auto cases = build_cases(read, fixture.registry());
  for (int repeat = 0; repeat < 3; ++repeat) {
    for (const std::size_t index : order_round(cases, 1, repeat))
      expected.push_back(cases[index].id + "#" + std::to_string(repeat) + (repeat == 0 ? "w" : ""));
  }
  for (const json& record : read_records(folder / "records.jsonl")) {
    EXPECT_EQ(record.at("outcome"), "accepted") << record.dump();
    order.push_back(record.at("case").get<std::string>() + "#" + record.at("repeat").dump() +
                    (record.at("warmup").get<bool>() ? "w" : ""));
  }
  EXPECT_EQ(order, expected);
  EXPECT_EQ(test::bytes_of(folder / "plan.yaml"), test::bytes_of(plan));
  EXPECT_TRUE(std::filesystem::exists(folder / "meshes/cube/seeded/seed=2.mesh"));
  EXPECT_FALSE(std::filesystem::exists(folder / ".scratch"));
  EXPECT_EQ(json::parse(test::bytes_of(folder / "provenance.json")).at("meshes").size(), 1U);
}

TEST(Runner, ACaseOfSeveralSeedsMayHaveRepeatsOfItsOwn) {
  const test::ExperimentFixture fixture;
  const auto plan = fixture.add_plan("\n  - test.copy\n  - {method: test.copy, label: seeded, seeds: 2}",
                                     "run: {repeats: 3, seed_repeats: 1, warmup: 1}\n");
  const auto folder = fixture.folder() / "run";
  run_quietly(fixture, plan, folder);
  std::map<std::string, int> repeats;
  for (const auto& [id, records] : records_by_case(folder)) repeats[id] = static_cast<int>(records.size());
  EXPECT_THAT(repeats, testing::IsSupersetOf({std::pair<const std::string, int>{"cube/test.copy", 4},
                                              {"cube/seeded/seed=1", 2},
                                              {"cube/seeded/seed=2", 2}}));
  EXPECT_EQ(json::parse(test::bytes_of(folder / "provenance.json")).at("repeats_of"),
            json({{"cube/seeded/seed=1", 1}, {"cube/seeded/seed=2", 1}}));
  EXPECT_EQ(run_quietly(fixture, plan, folder, true).records_added, 0);
}

TEST(Runner, OutcomesOfBadContestants) {
  const test::ExperimentFixture fixture;
  std::string contestants;
  const std::map<std::string, std::string> expected{{"invert", "rejected"},     {"drop_tet", "rejected"},
                                                    {"move_skin", "rejected"},  {"false_count", "rejected"},
                                                    {"nan_mesh", "bad_answer"}, {"crash", "crashed"},
                                                    {"hang", "timed_out"},      {"refuse", "bad_input"}};
  for (const auto& [behave, outcome] : expected) {
    contestants += "\n  - {method: test.copy, label: " + behave + ", set: {behave: " + behave + "}}";
  }
  const auto plan = fixture.add_plan(
      contestants, "run: {repeats: 2, timeout_s: 3}\naccept: {boundary_changed_faces: {max: 0}}\n");
  const RunResult result = run_quietly(fixture, plan, fixture.folder() / "run");
  EXPECT_TRUE(result.required_failed);
  EXPECT_TRUE(result.required_rejected);
  const auto records = records_by_case(fixture.folder() / "run");
  for (const auto& [behave, outcome] : expected) {
    const json& record = records.at("cube/" + behave).front();
    EXPECT_EQ(record.at("outcome"), outcome) << behave << ": " << record.dump();
    EXPECT_NE(record.at("message"), "") << behave;
  }
  EXPECT_EQ(records.at("cube/crash").size(), 2U);
  EXPECT_EQ(records.at("cube/hang").size(), 1U) << "a time-out is not repeated";
  EXPECT_EQ(records.at("cube/refuse").size(), 1U);
  EXPECT_THAT(records.at("cube/false_count")[0].at("message").get<std::string>(),
              HasSubstr("the judge counts 384"));
  EXPECT_THAT(records.at("cube/nan_mesh")[0].at("message").get<std::string>(), HasSubstr("out.mesh:5"));
  EXPECT_EQ(records.at("cube/crash")[0].at("null_reasons").at("kernel_s"), "crashed");
}

TEST(Runner, SharpEdgesAreLookedForInEveryOutput) {
  const test::ExperimentFixture fixture;
  const auto plan = fixture.add_plan("\n  - {method: test.copy, label: same}",
                                     "feature_deg: 40\nmeasure: [feature_edges, feature_distance_upper]\n"
                                     "accept: {feature_distance_upper: {max: 0}}\n");
  run_quietly(fixture, plan, fixture.folder() / "run");
  const auto records = records_by_case(fixture.folder() / "run");
  const json& same = records.at("cube/same").front();
  EXPECT_EQ(same.at("outcome"), "accepted") << same.dump();
  EXPECT_EQ(same.at("judge").at("feature_edges"), 48);  // twelve edges of four cells
  EXPECT_EQ(same.at("judge").at("feature_distance_upper"), 0.0);
}

TEST(Runner, ARegionToKeepMeetsOneOfTheMeshesAtLeast) {
  const test::ExperimentFixture fixture;
  write_medit(fixture.folder() / "far.mesh", [] {
    TetMesh mesh = build_kuhn_cube(2, 0.0, 0);
    for (Vec3& p : mesh.points) p.x += 10.0;
    return mesh;
  }());
  const auto plan = [&](const std::string& region) {
    return fixture.folder().add(
        "far.yaml",
        "schema: palpate/plan/1\nquestion: q\ncontest: simplify\nmeshes: [{name: cube, file: "
        "cube.mesh}, {name: far, file: far.mesh}]\ncontestants:\n  - {method: test.keep, keep: "
        "[half_space 0 0 1 0.5, " +
            region + "]}\n");
  };
  const auto folder = fixture.folder() / "run";
  EXPECT_THAT(
      run_error(fixture, plan("sphere 9 9 9 1"), folder, false),
      HasSubstr("far.yaml:6: keep: expected a region in the meshes' own coordinates that meets one of them, "
                "found \"sphere 9 9 9 1\", which no tetrahedron meets"));
  EXPECT_FALSE(std::filesystem::exists(folder / "records.jsonl"));
  EXPECT_EQ(run_error(fixture, plan("sphere 10 0 0 0.1"), folder, false), "no error")
      << "it meets the second";
}

TEST(Runner, ABrokenPromiseToKeepARegionIsAViolation) {
  const test::ExperimentFixture fixture;
  // 384 tets in [0, 1]^3; half_space 0 0 -1 -0.9 is z >= 0.9, the top layer of 96.
  const std::string region = "keep: [half_space 0 0 -1 -0.9]";
  const auto plan = fixture.add_plan("\n  - {method: test.keep, label: keeps, " + region +
                                         "}\n  - {method: test.keep, label: breaks, " + region +
                                         ", set: {behave: drop_tet}}\n  - {method: test.copy, label: free}",
                                     "region: [half_space 0 0 1 0.1]\naccept: {kept_tets_changed: {max: 0}, "
                                     "region_tets: {min: 96, max: 96}}\n");
  run_quietly(fixture, plan, fixture.folder() / "run");
  const auto records = records_by_case(fixture.folder() / "run");
  const json& keeps = records.at("cube/keeps").front();
  EXPECT_EQ(keeps.at("outcome"), "accepted") << keeps.dump();
  EXPECT_EQ(keeps.at("keep"), json({"half_space 0 0 -1 -0.9"}));
  EXPECT_EQ(keeps.at("judge").at("kept_tets"), 96);
  EXPECT_EQ(keeps.at("judge").at("kept_tets_changed"), 0);
  const json& breaks = records.at("cube/breaks").front();
  EXPECT_EQ(breaks.at("outcome"), "rejected");
  EXPECT_EQ(breaks.at("judge").at("kept_tets_changed"), 1);
  EXPECT_THAT(breaks.at("violations").dump(), HasSubstr("kept_tets_changed is 1, at most 0 is accepted"));
  const json& free = records.at("cube/free").front();
  EXPECT_EQ(free.at("outcome"), "accepted");
  EXPECT_EQ(free.at("judge").at("kept_tets"), 0);
  EXPECT_EQ(free.at("judge").at("region_tets"), 96);
  EXPECT_EQ(records.at("cube/input").front().at("judge").at("region_tets"), 96);
  const json provenance = json::parse(test::bytes_of(fixture.folder() / "run/provenance.json"));
  EXPECT_THAT(provenance.at("plan_data").dump(), HasSubstr("half_space 0 0 -1 -0.9"));
}

TEST(Runner, AContestantThatChangesItsInputHarmsNobodyElse) {
  const test::ExperimentFixture fixture;
  const auto folder = fixture.folder() / "run";
  ::setenv("PALPATE_TEST_SOURCE_MESH", (folder / "meshes/cube/input.mesh").c_str(), 1);
  const auto plan = fixture.add_plan(
      "\n  - {method: test.copy, label: a, set: {behave: overwrite_input}}\n  - {method: test.copy, label: "
      "b, "
      "set: {behave: overwrite_source}}\n  - {method: test.copy, label: c}");
  run_quietly(fixture, plan, folder);
  ::unsetenv("PALPATE_TEST_SOURCE_MESH");
  const auto records = records_by_case(folder);
  for (const char* spoiler : {"cube/a", "cube/b"}) {
    EXPECT_EQ(records.at(spoiler).front().at("outcome"), "bad_answer");
    EXPECT_EQ(records.at(spoiler).front().at("message"), "it changed its input input.mesh") << spoiler;
    EXPECT_TRUE(records.at(spoiler).front().at("kernel_s").is_null());
  }
  const json& next = records.at("cube/c").front();
  EXPECT_EQ(next.at("outcome"), "accepted") << next.dump();
  EXPECT_EQ(next.at("report").at("tets_in"), 384) << "it was given the whole mesh";
  EXPECT_EQ(test::bytes_of(folder / "meshes/cube/input.mesh"),
            test::bytes_of(fixture.folder() / "cube.mesh"));
}

TEST(Runner, OptionalContestantDoesNotDecide) {
  const test::ExperimentFixture fixture;
  const auto plan = fixture.add_plan(
      "\n  - test.copy\n  - {method: test.copy, label: b, set: {behave: crash}, required: false}");
  const RunResult result = run_quietly(fixture, plan, fixture.folder() / "run");
  EXPECT_FALSE(result.required_failed);
  EXPECT_EQ(result.failures.count("cube/b"), 1U);
}

TEST(Runner, ASearchIsMadeOnceACase) {
  const test::ExperimentFixture fixture;
  const auto plan =
      fixture.add_plan("[{method: test.copy, label: a, set: {behave: tune}}, {method: test.copy, label: b}]",
                       "run: {repeats: 2, warmup: 1}\n");
  const auto folder = fixture.folder() / "run";
  run_quietly(fixture, plan, folder);
  const auto records = records_by_case(folder);
  const auto& a = records.at("cube/a");
  ASSERT_EQ(a.size(), 3U);
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].at("outcome"), "accepted") << a[i].dump();
    EXPECT_EQ(a[i].at("tuned"), (json{{"length", 0.5}}));
    EXPECT_EQ(a[i].at("searched"), i == 0);
  }
  for (const json& record : records.at("cube/b")) {
    EXPECT_EQ(record.at("tuned"), json::object());
    EXPECT_EQ(record.at("searched"), false);
  }
}

TEST(Runner, AResumedRunHandsBackWhatASearchFound) {
  const test::ExperimentFixture fixture;
  const std::string contestants = "[{method: test.copy, label: a, set: {behave: tune}}]";
  const auto folder = fixture.folder() / "run";
  const auto plan = fixture.add_plan(contestants, "run: {repeats: 3}\n");
  run_quietly(fixture, plan, folder);
  // As if it had been stopped after the first repeat, with another length found.
  std::string kept;
  for (json& record : read_records(folder / "records.jsonl")) {
    if (record.at("repeat") != 0) continue;
    if (record.at("label") == "a") record["tuned"] = {{"length", 0.125}};
    kept += record.dump() + "\n";
  }
  fixture.folder().add("run/records.jsonl", kept);
  run_quietly(fixture, plan, folder, true);
  const auto records = records_by_case(folder);
  const auto& a = records.at("cube/a");
  ASSERT_EQ(a.size(), 3U);
  for (std::size_t i = 1; i < a.size(); ++i) {
    EXPECT_EQ(a[i].at("tuned"), (json{{"length", 0.125}}));
    EXPECT_EQ(a[i].at("searched"), false);
  }
}

TEST(Runner, AMethodThatIsNotDeterministicIsJudgedInEachRepeat) {
  const test::ExperimentFixture fixture;
  const auto plan = fixture.add_plan("[{method: test.varying, label: a}]", "run: {repeats: 6}\n");
  run_quietly(fixture, plan, fixture.folder() / "run");
  int differing = 0;
  const auto records = records_by_case(fixture.folder() / "run");
  for (const json& record : records.at("cube/a")) {
    EXPECT_EQ(record.at("outcome"), "accepted") << record.dump();
    EXPECT_TRUE(record.at("judge").at("valid").get<bool>());
    differing +=
        record.at("notes").dump().find("output differs between repeats") != std::string::npos ? 1 : 0;
  }
  EXPECT_GE(differing, 1) << "six times the same of 97 rotations";
}

TEST(Runner, AnotherOutputInARepeatIsAViolation) {
  const test::ExperimentFixture fixture;
  const auto plan =
      fixture.add_plan("[{method: test.copy, label: a, set: {behave: alternate}}]", "run: {repeats: 6}\n");
  run_quietly(fixture, plan, fixture.folder() / "run");
  const auto records = records_by_case(fixture.folder() / "run").at("cube/a");
  EXPECT_EQ(records.front().at("outcome"), "accepted");
  std::size_t violations = 0;
  for (const json& record : records) {
    violations += record.at("violations") == json::array({"output differs between repeats"}) ? 1 : 0;
  }
  EXPECT_GT(violations, 0U);
}

TEST(Runner, TetsOfTakesTheOtherCasesCount) {
  const test::ExperimentFixture fixture;
  const auto plan = fixture.add_plan(
      "\n  - {method: test.copy, label: b, stop: {tets_of: a}}\n  - {method: test.copy, label: "
      "a, stop: {ratio: 0.5}}");
  run_quietly(fixture, plan, fixture.folder() / "run");
  const json stop = records_by_case(fixture.folder() / "run").at("cube/b")[0].at("stop");
  EXPECT_EQ(stop, json({{"kind", "tets"}, {"value", 384}, {"of", "a"}}));
}

TEST(Runner, TetsOfACaseWithoutAMeshIsAnError) {
  const test::ExperimentFixture fixture;
  const auto plan = fixture.add_plan(
      "\n  - {method: test.copy, label: b, stop: {tets_of: a}}\n  - {method: test.copy, label: a, set: "
      "{behave: crash}}");
  run_quietly(fixture, plan, fixture.folder() / "run");
  const json record = records_by_case(fixture.folder() / "run").at("cube/b")[0];
  EXPECT_EQ(record.at("outcome"), "error");
  EXPECT_THAT(record.at("message").get<std::string>(), HasSubstr("cube/a, which left no mesh"));
}

}  // namespace
}  // namespace palpate::experiments

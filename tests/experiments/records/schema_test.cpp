// Plans, descriptions and records against experiments/schema, by Debian's python3-jsonschema.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <functional>

#include "core/base/error.h"
#include "experiments/files/places.h"
#include "experiments/processes/process.h"
#include "experiments/records/record_file.h"
#include "experiments/runner/plan_schema.h"
#include "experiments/text/yaml_value.h"
#include "reference/door/json_file.h"
#include "tests/support/experiment_fixture.h"
#include "tests/support/scene_text.h"
#include "tests/support/test_folder.h"

namespace palpate::experiments {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// What the validator says to a list of instances; empty if all are good.
std::string validate(const std::string& schema, const json& instances) {
  const test::ScratchFolder folder;
  const auto script = folder.add(
      "validate.py",
      "import json, sys\nfrom jsonschema import Draft202012Validator as V\n"
      "schema = json.load(open(sys.argv[1]))\nV.check_schema(schema)\n"
      "errors = [e.message for i in json.load(open(sys.argv[2])) for e in V(schema).iter_errors(i)]\n"
      "print('\\n'.join(errors), end='')\nsys.exit(1 if errors else 0)\n");
  ProcessSpec spec;
  spec.arguments = {"/usr/bin/python3", "-B", script.string(),
                    experiments::source_folder() + "/experiments/schema/" + schema,
                    folder.add("instances.json", instances.dump()).string()};
  spec.standard_output = folder / "out";
  spec.standard_error = folder / "error";
  const ProcessResult result = run_process(spec);
  if (result.end == ProcessEnd::kExited && result.exit_code == 0) return "";
  return result.message + ": " + test::bytes_of(folder / "out") + test::bytes_of(folder / "error");
}

json yaml_files(const fs::path& folder, const std::string& name_end) {
  json all = json::array();
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (name.size() >= name_end.size() && name.ends_with(name_end))
      all.push_back(read_yaml(entry.path()).json());
  }
  return all;
}

/// The first judgement of a label: rounds are run in a random order.
json& judgement_of(json& records, const std::string& label) {
  for (json& record : records) {
    if (record.at("label") == label && record.at("judge").is_object()) return record["judge"];
  }
  throw InputError("nothing of " + label + " was judged");
}

TEST(Schema, PlansOfTheProject) {
  const json plans = yaml_files(fs::path(experiments::source_folder()) / "experiments/plans", ".yaml");
  ASSERT_GT(plans.size(), 0U);
  EXPECT_EQ(validate("plan.schema.json", plans), "");
  json broken = plans;
  broken[0]["contestnts"] = 1;
  EXPECT_NE(validate("plan.schema.json", broken), "");
}

TEST(Schema, ThatOfPlansIsMadeFromTheTableOfContests) {
  const fs::path folder = fs::path(experiments::source_folder()) / "experiments/schema";
  const std::string values = test::bytes_of(folder / "plan_values.json");
  auto parsed = reference::parse_ordered_json(values, "plan_values.json");
  EXPECT_EQ(test::bytes_of(folder / "plan.schema.json"), write_plan_schema(parsed))
      << "build/release/bin/print_plan_schema > experiments/schema/plan.schema.json";
  parsed["properties"]["colour"] = true;
  EXPECT_THROW(write_plan_schema(parsed), InputError);
  parsed["properties"].erase("colour");
  parsed["properties"].erase("sweep");
  EXPECT_THROW(write_plan_schema(parsed), InputError);
}

TEST(Schema, TrainingPlansOfTheProject) {
  const json plans = yaml_files(fs::path(experiments::source_folder()) / "experiments/training", ".yaml");
  ASSERT_GT(plans.size(), 0U);
  EXPECT_EQ(validate("training.schema.json", plans), "");
  json broken = plans;
  broken[0]["clamps"]["back"][0]["elastic"] = 1;
  EXPECT_NE(validate("training.schema.json", broken), "");
}

TEST(Schema, DescriptionsOfTheProject) {
  json descriptions = yaml_files(fs::path(experiments::source_folder()) / "reference", "contestant.yaml");
  ASSERT_GT(descriptions.size(), 0U);
  descriptions.push_back(read_yaml(fs::path(test::test_folder()) / "contestant/contestant.yaml").json());
  EXPECT_EQ(validate("contestant.schema.json", descriptions), "");
  descriptions.back()["methods"][0].erase("stops");
  EXPECT_NE(validate("contestant.schema.json", descriptions), "");
}

TEST(Schema, DescriptionsHaveAProgramOrACommand) {
  json own = read_yaml(fs::path(test::test_folder()) / "contestant/contestant.yaml").json();
  own.erase("program");
  EXPECT_NE(validate("contestant.schema.json", json::array({own})), "");
  own["command"] = {"python3", "adapter.py"};
  own["files"] = {"weights.txt"};
  EXPECT_EQ(validate("contestant.schema.json", json::array({own})), "");
  own["program"] = "p";
  EXPECT_NE(validate("contestant.schema.json", json::array({own})), "");
}

TEST(Schema, AcceptedFiguresOfTheProject) {
  json files = json::array();
  for (const auto& entry :
       fs::directory_iterator(fs::path(experiments::source_folder()) / "results/accepted"))
    files.push_back(json::parse(test::bytes_of(entry.path())));
  ASSERT_GT(files.size(), 0U);
  files.push_back(json::parse(
      test::bytes_of(fs::path(experiments::source_folder()) / "docs/examples/hosted_ci/accepted.json")));
  EXPECT_EQ(validate("accepted.schema.json", files), "");
  const auto refuses = [&](const std::function<void(json&)>& spoil) {
    json broken = files.back();
    spoil(broken);
    return !validate("accepted.schema.json", json::array({broken})).empty();
  };
  EXPECT_TRUE(refuses([](json& file) { file["figures"][0].erase("kind"); }));
  EXPECT_TRUE(refuses([](json& file) { file["figures"][0]["kind"] = "time"; }));
  EXPECT_TRUE(refuses([](json& file) { file["figures"][0]["colour"] = 1; }));
  EXPECT_TRUE(refuses([](json& file) { file["schema"] = "palpate/accepted/1"; })) << "it has no kinds";
}

TEST(Schema, ScenesOfTheProject) {
  const json scenes = yaml_files(fs::path(experiments::source_folder()) / "experiments/scenes", ".yaml");
  ASSERT_GT(scenes.size(), 0U);
  EXPECT_EQ(validate("scene.schema.json", scenes), "");
  json broken = scenes;
  broken[0]["material"]["poisson_ratio"] = 0.5;
  EXPECT_NE(validate("scene.schema.json", broken), "");
}

TEST(Schema, RecordsOfAContestOfDisplacements) {
  const test::ExperimentFixture fixture;
  fixture.folder().add("block.yaml", test::SceneText().yaml());
  const auto plan = fixture.folder().add(
      "plan.yaml",
      "schema: palpate/plan/1\nquestion: q\ncontest: deform\nscenes: [{name: block, file: block.yaml}]\n"
      "reference: {method: test.field, set: {bias: 0.1}}\nsimplify: [none, {method: test.copy, stop: {limit: "
      "true}}]\ncontestants: [test.field, {method: test.field, label: dive, set: {behave: diverge}}, "
      "{method: "
      "test.field, label: refuse, set: {behave: refuse}}]\n");
  EXPECT_EQ(validate("plan.schema.json", json::array({read_yaml(plan).json()})), "");
  const auto folder = fixture.folder() / "run";
  test::run_program({"run", plan.string(), "--out", folder.string(), "--no-report"});
  json records = read_records(folder / "records.jsonl");
  ASSERT_EQ(records.size(), 7U);
  EXPECT_EQ(validate("record.schema.json", records), "");
  judgement_of(records, "test.field")["displacement_l2"] = -1.0;
  EXPECT_NE(validate("record.schema.json", records), "");
}

TEST(Schema, RecordsOfTheEngine) {
  const test::ExperimentFixture fixture;
  test::SceneText text;
  text.rest = "strain: large\nmodel: {springs: van_gelder}\n";
  text.clamp = "[{half_space: {normal: [0, 0, 1], offset_m: 0}, elastic_pa_per_m: 1.0e6}]";
  text.load =
      "[{displace: {half_space: {normal: [0, 0, -1], offset_m: -0.1}, by_m: [0, 0, -0.002], "
      "elastic_pa_per_m: "
      "5.0e6}}]";
  text.analysis =
      "{dynamic: {integrator: symplectic_euler, time_step_s: auto, duration_s: 0.05, engine: auto, "
      "precision: "
      "single, damping: {stiffness_s: 0.002}}}";
  const auto scene = fixture.folder().add("held.yaml", text.yaml());
  EXPECT_EQ(validate("scene.schema.json", json::array({read_yaml(scene).json()})), "");
  const auto plan = fixture.folder().add(
      "plan.yaml",
      "schema: palpate/plan/1\nquestion: q\ncontest: engine\nscenes: [{name: held, file: held.yaml}]\n"
      "reference: {method: test.field}\ncontestants: [engine.replay, engine.rest, {method: engine.ticks, "
      "scenes: "
      "[held], set: {ticks: 100}}]\n");
  EXPECT_EQ(validate("plan.schema.json", json::array({read_yaml(plan).json()})), "");
  const auto folder = fixture.folder() / "run";
  test::run_program({"run", plan.string(), "--out", folder.string(), "--no-report"});
  json records = read_records(folder / "records.jsonl");
  ASSERT_EQ(records.size(), 4U);
  EXPECT_EQ(validate("record.schema.json", records), "");
  judgement_of(records, "engine.ticks")["tick_p50_s"] = "fast";
  EXPECT_NE(validate("record.schema.json", records), "");
}

TEST(Schema, RecordsOfAContestOfMotions) {
  const test::ExperimentFixture fixture;
  test::SceneText scene;
  scene.load =
      "[{displace: {half_space: {normal: [0, 0, -1], offset_m: -0.1}, by_m: [0, 0, -0.01], elastic_pa_per_m: "
      "5.0e6}, profile: {times_s: [0, 0.05], shares: [0, 1]}}]";
  scene.analysis =
      "{dynamic: {integrator: symplectic_euler, time_step_s: auto, duration_s: 0.2, probes_m: [[0, 0, "
      "0.1]]}}";
  fixture.folder().add("block.yaml", scene.yaml());
  const auto plan = fixture.folder().add(
      "plan.yaml",
      "schema: palpate/plan/1\nquestion: q\ncontest: motion\nscenes: [{name: block, file: block.yaml}]\n"
      "reference: {method: test.ringing, levels: 2, stated_order: 2, set: {bias: 0.1}}\n"
      "contestants: [test.ringing, {method: test.ringing, label: dive, set: {behave: diverge}}]\n");
  EXPECT_EQ(validate("plan.schema.json", json::array({read_yaml(plan).json()})), "");
  const auto folder = fixture.folder() / "run";
  test::run_program({"run", plan.string(), "--out", folder.string(), "--no-report"});
  json records = read_records(folder / "records.jsonl");
  ASSERT_EQ(records.size(), 3U);
  EXPECT_EQ(validate("record.schema.json", records), "");
  judgement_of(records, "test.ringing")["probe_l2"] = -1.0;
  EXPECT_NE(validate("record.schema.json", records), "");
}

TEST(Schema, RecordsOfARun) {
  const test::ExperimentFixture fixture;
  std::string contestants;
  for (const char* behave :
       {"copy", "invert", "crash", "garbage", "refuse", "fail", "nan_mesh", "drop_tet", "tune", "hang"}) {
    contestants +=
        std::string("\n  - {method: test.copy, label: ") + behave + ", set: {behave: " + behave + "}}";
  }
  contestants += "\n  - {method: test.copy, label: after_crash, stop: {tets_of: crash}}";
  const auto plan = fixture.add_plan(contestants, "run: {repeats: 2, warmup: 1, timeout_s: 3}\n");
  const auto folder = fixture.folder() / "run";
  test::run_program({"run", plan.string(), "--out", folder.string(), "--no-report"});
  json records = read_records(folder / "records.jsonl");
  ASSERT_GT(records.size(), 20U);
  EXPECT_EQ(validate("record.schema.json", records), "");
  records[0]["judge"]["inverted_tets"] = "none";
  EXPECT_NE(validate("record.schema.json", records), "");
}

}  // namespace
}  // namespace palpate::experiments

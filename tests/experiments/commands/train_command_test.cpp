// palpate train from plan to springs, on a small cube, and plans whose contestants are trained first.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "core/springs/network/moduli_csv.h"
#include "core/springs/network/springs_csv.h"
#include "experiments/records/record_file.h"
#include "experiments/scene_reader/scene_problem.h"
#include "experiments/spring_training/training_plan.h"
#include "tests/support/experiment_fixture.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;
using test::ProgramResult;
using test::run_program;
using testing::HasSubstr;

constexpr const char* kTraining = R"(schema: palpate/training/1
mesh: {make: cube, vertices: 27, unit_m: 0.1}
material: {young_modulus_pa: 10000, poisson_ratio: 0.25, density_kg_m3: 1000}
springs: {start: isotropy_patch, volume: none}
reference: {refine: 0}
fit: {ridges: [0.01, 0.0001], iterations: 15}
clamps:
  low: [{half_space: {normal: [0, 0, 1], share: 0.1}, elastic_pa_per_m: 1.0e6}]
  side: [{half_space: {normal: [1, 0, 0], share: 0.1}, elastic_pa_per_m: 1.0e6}]
loads:
  weight: [{gravity_m_s2: [0, 0, -9.81]}]
  wind: [{gravity_m_s2: [9.81, 0, 0]}]
  storm: [{gravity_m_s2: [5, 5, 0]}]
  push: [{force: {half_space: {normal: [0, 0, -1], share: 0.1}, total_n: [0.2, 0, -1]}}]
train: {clamps: [low], loads: [weight, wind]}
validate: {clamps: [low], loads: [push]}
test_loads: {clamps: [low], loads: [storm]}
test_clamps: {clamps: [side], loads: [weight]}
)";

constexpr const char* kScene = R"(schema: palpate/scene/1
mesh: {make: cube, vertices: 27, unit_m: 0.1}
material: {young_modulus_pa: 10000, poisson_ratio: 0.25, density_kg_m3: 1000}
clamp: [{half_space: {normal: [0, 0, 1], share: 0.1}, elastic_pa_per_m: 1.0e6}]
load: [{gravity_m_s2: [3, 4, 5]}]
analysis: static
)";

/// A training plan in a scratch folder, and a cache of the test's own.
class TrainCommand : public testing::Test {
 protected:
  TrainCommand() { use_cache("cache"); }
  ~TrainCommand() override { ::unsetenv("PALPATE_CACHE"); }

  void use_cache(const std::string& name) { ::setenv("PALPATE_CACHE", (folder() / name).c_str(), 1); }

  const test::ScratchFolder& folder() const { return fixture_.folder(); }

  std::filesystem::path add_training(const std::string& from = "", const std::string& to = "") {
    std::string text = kTraining;
    if (!from.empty()) text.replace(text.find(from), from.size(), to);
    return folder().add("training.yaml", text);
  }

  ProgramResult train(const std::filesystem::path& plan, const std::string& out,
                      const std::vector<std::string>& more = {}) {
    std::vector<std::string> words{"train", plan.string(), "-o", (folder() / out).string(), "--json"};
    words.insert(words.end(), more.begin(), more.end());
    return run_program(words);
  }

  test::ExperimentFixture fixture_;
};

double error_of(const json& report, const std::string& set, const std::string& model) {
  return report.at("sets").at(set).at("models").at(model).at("rms").get<double>();
}

TEST_F(TrainCommand, LearnsFromQuadraticElementsAndReportsEverySetApart) {
  const auto plan = add_training();
  const ProgramResult result = train(plan, "k.csv");
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const json report = json::parse(result.out);
  EXPECT_EQ(report.at("sets").size(), 4U);
  for (const char* set : {"train", "validate", "test_loads", "test_clamps"})
    for (const char* model : {"start", "calibrated_opposite", "fem_p1", "trained"})
      EXPECT_GT(error_of(report, set, model), 0.0) << set << ' ' << model;
  EXPECT_LT(error_of(report, "train", "trained"), 0.5 * error_of(report, "train", "start"));
  // The ridge of the least validation error, and its constants, are the ones that are kept.
  double least = 1.0;
  for (const json& ridge : report.at("ridges"))
    least = std::min(least, ridge.at("validate_rms").get<double>());
  EXPECT_EQ(error_of(report, "validate", "trained"), least);
  EXPECT_EQ(report.at("kept"), "trained");
  EXPECT_EQ(report.at("start_validate_rms"), error_of(report, "validate", "start"));
  EXPECT_LT(least, error_of(report, "validate", "start"));
  const TetMesh mesh = build_scene_mesh(read_training_plan(plan).mesh).mesh;
  const SpringNetwork network = springs::read_springs_csv(folder() / "k.csv", mesh);
  EXPECT_GT(*std::min_element(network.stiffness_n_per_m.begin(), network.stiffness_n_per_m.end()), 0.0);
}

TEST_F(TrainCommand, WhereTrainingDoesNotHelpItSaysSoAndKeepsTheStart) {
  // Fitted without a ridge to one field, and validated on one that it says nothing of.
  std::string text = kTraining;
  const auto put = [&](const std::string& from, const std::string& to) {
    text.replace(text.find(from), from.size(), to);
  };
  put("ridges: [0.01, 0.0001], iterations: 15", "ridges: [0.0], iterations: 60");
  put("train: {clamps: [low], loads: [weight, wind]}", "train: {clamps: [low], loads: [weight]}");
  put("validate: {clamps: [low], loads: [push]}", "validate: {clamps: [low], loads: [wind]}");
  const auto plan = folder().add("training.yaml", text);
  const ProgramResult result = train(plan, "k.csv");
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const json report = json::parse(result.out);
  ASSERT_GT(report.at("ridges").at(0).at("validate_rms"), report.at("start_validate_rms"));
  EXPECT_EQ(report.at("kept"), "start");
  EXPECT_TRUE(report.at("ridge").is_null());
  EXPECT_EQ(error_of(report, "validate", "trained"), error_of(report, "validate", "start"));
  const ProgramResult table = run_program({"train", plan.string(), "-o", (folder() / "k2.csv").string()});
  EXPECT_THAT(table.out, HasSubstr("Training did not help: on the validation set the start is at"));
  EXPECT_EQ(test::bytes_of(folder() / "k.csv"), test::bytes_of(folder() / "k2.csv"));
}

TEST_F(TrainCommand, TheSameBytesOnOneThreadAndTwo) {
  const auto plan = add_training();
  ASSERT_EQ(train(plan, "one.csv").exit_code, 0);
  use_cache("another_cache");
  ASSERT_EQ(train(plan, "two.csv", {"--threads", "2"}).exit_code, 0);
  EXPECT_EQ(test::bytes_of(folder() / "one.csv"), test::bytes_of(folder() / "two.csv"));
}

TEST_F(TrainCommand, ModuliAreTrainedWithAVolumeModel) {
  auto plan = add_training("volume: none", "volume: node_average");
  std::string text = test::bytes_of(plan);
  text.replace(text.find("poisson_ratio: 0.25"), 19, "poisson_ratio: 0.45");
  plan = folder().add("training.yaml", text);
  ProgramResult result = train(plan, "k.csv");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.error, HasSubstr("--moduli"));
  result = train(plan, "k.csv", {"--moduli", (folder() / "m.csv").string()});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const TetMesh mesh = build_scene_mesh(read_training_plan(plan).mesh).mesh;
  EXPECT_TRUE(springs::read_moduli_csv(folder() / "m.csv", mesh).at_vertices);
  // The door's own solver finds the error that the report has: files and models agree.
  const json report = json::parse(result.out);
  folder().add("scene.yaml", std::string(kScene).replace(std::string(kScene).find("0.25"), 4, "0.45"));
  const auto run_plan = folder().add(
      "plan.yaml",
      "schema: palpate/plan/1\nquestion: Does the file hold what was trained?\ncontest: deform\n"
      "scenes: [{name: block, file: scene.yaml}]\nreference: {method: fem.p2, levels: 1}\ncontestants:\n"
      "  - {method: springs.trained, label: own, train: training.yaml}\n"
      "  - {method: springs.trained, label: file, set: {springs: k.csv, moduli: m.csv}}\n");
  const ProgramResult run =
      run_program({"run", run_plan.string(), "--out", (folder() / "run").string(), "--no-report"});
  ASSERT_EQ(run.exit_code, 0) << run.error << run.out;
  std::map<std::string, json> records;
  for (const json& record : read_records(folder() / "run" / "records.jsonl"))
    records[record.at("label").get<std::string>()] = record;
  EXPECT_EQ(records.at("own").at("output_hash"), records.at("file").at("output_hash"));
  EXPECT_EQ(records.at("own").at("files"), records.at("file").at("files"));
  EXPECT_EQ(records.at("own").at("files").size(), 2U);
  EXPECT_EQ(records.at("own").at("options").at("springs"), "springs.csv");
  EXPECT_EQ(records.at("file").at("options").at("springs"), "k.csv");
  const json provenance = json::parse(test::bytes_of(folder() / "run" / "provenance.json"));
  EXPECT_EQ(provenance.at("trained").at("own").at("report").at("ridge"), report.at("ridge"));
  // Another file under the same name is not the same run.
  folder().add("m.csv", test::bytes_of(folder() / "m.csv") + "\n");
  const ProgramResult again =
      run_program({"run", run_plan.string(), "--out", (folder() / "run").string(), "--resume"});
  EXPECT_EQ(again.exit_code, 2);
  EXPECT_THAT(again.error, HasSubstr("file.moduli changed"));
}

TEST_F(TrainCommand, SpringsOfAnotherMeshAreRefused) {
  add_training();
  folder().add("scene.yaml", std::string(kScene).replace(std::string(kScene).find("27"), 2, "64"));
  const auto plan = folder().add(
      "plan.yaml",
      "schema: palpate/plan/1\nquestion: Whose springs?\ncontest: deform\n"
      "scenes: [{name: block, file: scene.yaml}]\nreference: {method: fem.p2, levels: 1}\ncontestants:\n"
      "  - {method: springs.trained, label: own, train: training.yaml}\n");
  const ProgramResult run =
      run_program({"run", plan.string(), "--out", (folder() / "run").string(), "--no-report"});
  EXPECT_EQ(run.exit_code, 3) << run.error << run.out;
  const auto records = read_records(folder() / "run" / "records.jsonl");
  EXPECT_EQ(records.back().at("outcome"), "bad_input");
  EXPECT_THAT(records.back().at("message").get<std::string>(), HasSubstr("of another mesh"));
}

TEST_F(TrainCommand, BadPlansAreRefusedBeforeAnythingRuns) {
  const auto complaint = [&](const std::string& contestant) {
    folder().add("scene.yaml", kScene);
    const auto plan = folder().add(
        "plan.yaml",
        "schema: palpate/plan/1\nquestion: What is wrong?\ncontest: deform\n"
        "scenes: [{name: block, file: scene.yaml}]\nreference: {method: fem.p2}\ncontestants: [" +
            contestant + "]\n");
    const ProgramResult result = run_program({"check", plan.string()});
    EXPECT_EQ(result.exit_code, 2) << contestant;
    EXPECT_EQ(std::count(result.error.begin(), result.error.end(), '\n'), 1) << result.error;
    return result.error;
  };
  add_training("loads: [storm]", "loads: [weight]");
  EXPECT_THAT(complaint("{method: springs.trained, train: training.yaml}"), HasSubstr("is looked at by"));
  EXPECT_THAT(complaint("{method: springs.trained, train: nowhere.yaml}"), HasSubstr("found none at"));
  add_training();
  EXPECT_THAT(complaint("{method: springs.lloyd, train: training.yaml}"),
              HasSubstr("takes no trained springs"));
  folder().add("k.csv", "vertex_a\n");
  EXPECT_THAT(complaint("{method: springs.trained, train: training.yaml, set: {springs: k.csv}}"),
              HasSubstr("exclude each other"));
  EXPECT_THAT(complaint("{method: springs.trained, set: {springs: nowhere.csv}}"), HasSubstr("a file"));
  // The example's own mistake once: a direction in which the ray leaves the body nowhere is one line too.
  const ProgramResult result = train(folder().add("t.yaml", "schema: palpate/training/1\n"), "k2.csv");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_FALSE(std::filesystem::exists(folder() / "k2.csv"));
}

}  // namespace
}  // namespace palpate::experiments

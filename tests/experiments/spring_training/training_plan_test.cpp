#include "experiments/spring_training/training_plan.h"
#include "experiments/files/places.h"

#include <gtest/gtest.h>

#include <fstream>

#include "core/base/error.h"
#include "experiments/scene_reader/scene_problem.h"
#include "experiments/spring_training/training_run.h"
#include "tests/support/scratch_folder.h"

namespace {

using namespace palpate;
using namespace palpate::experiments;

constexpr const char* kPlan = R"(schema: palpate/training/1
mesh: {make: cube, vertices: 27, unit_m: 0.1}
material: {young_modulus_pa: 10000, poisson_ratio: 0.25, density_kg_m3: 1000}
springs: {start: isotropy_patch, volume: none}
reference: {refine: 0}
fit: {ridges: [0.01, 0.001], iterations: 20}
clamps:
  low: [{half_space: {normal: [0, 0, 1], share: 0.1}, elastic_pa_per_m: 1.0e6}]
  side: [{half_space: {normal: [1, 0, 0], share: 0.1}, elastic_pa_per_m: 1.0e6}]
  other: [{half_space: {normal: [0, 1, 0], share: 0.1}}]
loads:
  weight: [{gravity_m_s2: [0, 0, -9.81]}]
  wind: [{gravity_m_s2: [9.81, 0, 0]}]
  storm: [{gravity_m_s2: [5, 5, 0]}]
  push: [{force: {half_space: {normal: [0, 0, -1], share: 0.1}, total_n: [0, 0, -1]}}]
train: {clamps: [low, side], loads: [weight]}
validate: {clamps: [low], loads: [wind]}
test_loads: {clamps: [low], loads: [storm, push]}
test_clamps: {clamps: [other], loads: [weight, push]}
)";

/// The plan with `from` replaced by `to`, read.
TrainingPlan read_changed(const std::string& from = "", const std::string& to = "") {
  const test::ScratchFolder folder;
  std::string text = kPlan;
  if (!from.empty()) {
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
  }
  const auto path = folder.path() / "training.yaml";
  std::ofstream(path) << text;
  return read_training_plan(path);
}

/// What is said when `from` is replaced by `to`.
std::string complaint(const std::string& from, const std::string& to) {
  try {
    read_changed(from, to);
  } catch (const InputError& error) {
    return error.what();
  }
  return "nothing";
}

TEST(TrainingPlan, ReadsWhatItSays) {
  const TrainingPlan plan = read_changed();
  EXPECT_EQ(plan.clamps.size(), 3U);
  EXPECT_EQ(plan.loads.size(), 4U);
  EXPECT_EQ(plan.train.cases, (std::vector<TrainingPair>{{0, 0}, {1, 0}}));
  EXPECT_EQ(plan.test_clamps.cases, (std::vector<TrainingPair>{{2, 0}, {2, 3}}));
  EXPECT_EQ(plan.ridges, (std::vector<double>{0.01, 0.001}));
  EXPECT_EQ(plan.iterations, 20U);
  EXPECT_EQ(plan.refine, 0);
  EXPECT_EQ(plan.volume, TrainedVolume::kNone);
}

TEST(TrainingPlan, ASetMayBeSeveralBlocks) {
  const std::string one = "train: {clamps: [low, side], loads: [weight]}";
  const auto plan =
      read_changed(one, "train: [{clamps: [low, side], loads: [weight]}, {clamps: [side], loads: [wind]}]");
  EXPECT_EQ(plan.train.cases, (std::vector<TrainingPair>{{0, 0}, {1, 0}, {1, 1}}));
  EXPECT_NE(
      complaint(one, "train: [{clamps: [low, side], loads: [weight]}, {clamps: [side], loads: [weight]}]")
          .find("\"side\" with \"weight\" twice"),
      std::string::npos);
  EXPECT_NE(complaint(one, "train: []").find("blocks"), std::string::npos);
}

TEST(TrainingPlan, ThoseThatAreShippedFindTheirRegionsOnTheirMeshes) {
  const auto folder = std::filesystem::path(experiments::source_folder()) / "experiments" / "training";
  std::size_t plans = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const TrainingPlan plan = read_training_plan(entry.path());
    const TetMesh mesh = build_scene_mesh(plan.mesh).mesh;
    for (std::size_t clamp = 0; clamp < plan.clamps.size(); ++clamp)
      EXPECT_NO_THROW(place_case(plan, clamp, 0, mesh)) << plan.clamps[clamp].name;
    for (std::size_t load = 0; load < plan.loads.size(); ++load)
      EXPECT_NO_THROW(place_case(plan, 0, load, mesh)) << plan.loads[load].name;
    ++plans;
  }
  EXPECT_GT(plans, 0U);
}

TEST(TrainingPlan, RefusesATestSetThatAChoiceLooksAt) {
  EXPECT_NE(complaint("loads: [storm, push]", "loads: [storm, wind]").find("\"wind\" is looked at"),
            std::string::npos);
  EXPECT_NE(complaint("clamps: [other]", "clamps: [side]").find("\"side\" is looked at"), std::string::npos);
  EXPECT_NE(complaint("test_loads: {clamps: [low]", "test_loads: {clamps: [other]").find("not among train"),
            std::string::npos);
  EXPECT_NE(complaint("validate: {clamps: [low], loads: [wind]", "validate: {clamps: [low], loads: [weight]")
                .find("validates nothing"),
            std::string::npos);
}

TEST(TrainingPlan, RefusesWithTheLine) {
  const auto expect = [](const std::string& from, const std::string& to, const std::string& said) {
    const std::string what = complaint(from, to);
    EXPECT_NE(what.find("training.yaml:"), std::string::npos) << what;
    EXPECT_NE(what.find(said), std::string::npos) << what;
  };
  expect("palpate/training/1", "palpate/training/2", "palpate/training/1");
  expect("loads: [weight]}", "loads: [wieght]}", "weight");
  expect("loads: [storm, push]", "loads: [storm, storm]", "twice");
  expect("loads: [wind]}", "loads: []}", "at least one");
  expect("poisson_ratio: 0.25", "poisson_ratio: 0.45", "volume model");
  expect("poisson_ratio: 0.25", "poisson_ratio: 0.2", "springs alone");
  expect("volume: none", "volume: sponge", "none, tet or node_average");
  expect("ridges: [0.01, 0.001]", "ridges: []", "at least one");
  expect("ridges: [0.01, 0.001]", "ridges: [-1]", "-1");
  expect("iterations: 20", "iterations: 0", "0");
  expect("refine: 0", "refine: 9", "9");
  expect("young_modulus_pa: 10000", "young_modulus_pa: 0", "above 0");
  expect("[0, 0, -9.81]", "[0, 0, 0]", "does something");
  expect("reference:", "referenec:", "reference");
}

}  // namespace

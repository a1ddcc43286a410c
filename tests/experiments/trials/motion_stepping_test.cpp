// Integrators on a motion: what they take of memory counts.
#include "experiments/trials/motion_stepping.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/mesh/io/medit.h"
#include "experiments/scene_reader/scene_problem.h"
#include "experiments/text/yaml_value.h"
#include "experiments/trials/motion_trial.h"
#include "tests/support/experiment_fixture.h"
#include "tests/support/scene_text.h"

namespace palpate::experiments {
namespace {

using testing::HasSubstr;

/// A bar that swings.
SteppingTask bar_task(const test::ExperimentFixture& fixture, test::SceneText text = {}) {
  text.mesh = "{make: bar, vertices: 60, length_m: 0.1}";
  text.clamp = "[{half_space: {normal: [1, 0, 0], share: 0.1}, elastic_pa_per_m: 1.0e+6}]";
  text.analysis =
      "{dynamic: {integrator: symplectic_euler, time_step_s: auto, duration_s: 0.05, damping: {mass_per_s: "
      "20}}}";
  text.rest = "model: {smoothed: edge_node}\n";
  const std::filesystem::path file = fixture.folder().add("scene.yaml", text.yaml());
  const TetMesh mesh = build_scene_mesh(read_scene(file).mesh).mesh;
  SteppingTask task;
  task.mesh = fixture.folder() / "body.mesh";
  write_medit(task.mesh, mesh);
  task.scene = read_yaml(file).json();
  task.probes_m = spread_probes(mesh.points, kTrialProbes);
  task.most_error = 0.5;
  task.time_limit_s = 3000.0;  // of a machine that does other things too
  return task;
}

/// A body whose steps no engine counts to the end: it is no choice, and no end of the fit.
TEST(MotionStepping, AMotionWithoutAStepIsSaidOfEachIntegrator) {
  const test::ExperimentFixture fixture;
  test::SceneText text;
  text.material = "{young_modulus_pa: 1.0e+30, poisson_ratio: 0.45, density_kg_m3: 1.0e-30}";
  SteppingTask task = bar_task(fixture, text);
  task.folder = fixture.folder() / "trials";
  const std::vector<SteppingTry> tries = try_steppings(
      task, {{"explicit", kExplicitIntegrator, false, nullptr}, {"bdf2", "bdf2", false, nullptr}},
      fixture.registry());
  ASSERT_EQ(tries.size(), 2U);
  for (const SteppingTry& tried : tries)
    EXPECT_THAT(tried.why_not,
                testing::MatchesRegex(
                    "not tried: its motion was refused .*at most 1e12 steps.* before it had a step"));
  EXPECT_EQ(choose_stepping(tries), nullptr);
}

TEST(MotionStepping, WhatTakesMoreMemoryThanThereIsIsNoChoice) {
  const test::ExperimentFixture fixture;
  SteppingTask task = bar_task(fixture);
  const auto tried = [&](std::optional<std::uint64_t> memory_bytes, const char* folder) {
    task.memory_bytes = memory_bytes;
    task.folder = fixture.folder() / folder;
    return try_steppings(task, {{"explicit", kExplicitIntegrator, false, nullptr}}, fixture.registry())
        .front();
  };
  const SteppingTry free = tried(std::nullopt, "free");
  ASSERT_EQ(free.why_not, "");
  EXPECT_GT(free.memory_bytes, 1'000'000U) << "of a program, at least";
  EXPECT_EQ(tried(100 * free.memory_bytes, "enough").why_not, "");
  const SteppingTry over = tried(1000, "over");
  EXPECT_THAT(over.why_not, HasSubstr(" bytes, over 1000 at a step of "));
  EXPECT_EQ(choose_stepping({over}), nullptr);
}

}  // namespace
}  // namespace palpate::experiments

// palpate simulate and palpate check on scenes, as programs.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/mesh/io/displacement_vtu.h"
#include "core/mesh/io/medit.h"
#include "core/mesh/topology.h"
#include "experiments/meshes/mesh_source.h"
#include "reference/door/deform_problem.h"
#include "tests/support/experiment_fixture.h"
#include "tests/support/scene_text.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;
using test::run_program;
using test::SceneText;
using testing::HasSubstr;

class Simulate : public testing::Test {
 protected:
  std::string scene(const SceneText& text) const {
    return fixture_.folder().add("scene.yaml", text.yaml()).string();
  }

  test::ExperimentFixture fixture_;
};

TEST_F(Simulate, AStaticSceneLeavesItsDisplacement) {
  // Uniaxial compression between rollers: the displacement is linear, so that linear elements have it
  // exactly.
  SceneText text;
  text.clamp =
      "\n  - {half_space: {normal: [1, 0, 0], offset_m: 0}, axes: [x]}\n  - {half_space: {normal: [0, 1, 0], "
      "offset_m: 0}, axes: [y]}\n  - {half_space: {normal: [0, 0, 1], offset_m: 0}, axes: [z]}";
  text.load = "[{force: {half_space: {normal: [0, 0, -1], offset_m: -0.1}, total_n: [0, 0, -0.5]}}]";
  text.rest = "model: {finite_elements: p1}\n";
  const auto out = fixture_.folder() / "out";
  const auto result = run_program({"simulate", scene(text), "-o", out.string(), "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const json report = json::parse(result.out);
  EXPECT_EQ(report.at("outcome"), "converged");
  EXPECT_EQ(report.at("method"), "fem.p1");
  EXPECT_EQ(report.at("steps"), 1);
  EXPECT_GT(report.at("kernel_s").get<double>(), 0.0);
  EXPECT_EQ(report.at("files").size(), 2U);
  const TetMesh mesh = read_medit(fixture_.folder() / "cube.mesh").mesh;
  const auto field = reference::read_displacement(out / "displacement.csv", mesh.points.size(), 0);
  double most = 0.0;
  for (const Vec3& u : field) most = std::max(most, length(u));
  EXPECT_EQ(report.at("max_displacement_m"), most);
  // 0.5 N on 0.01 m^2 of E = 10 kPa: strain 0.005 down, a quarter of it to either side, over 0.1 m.
  EXPECT_NEAR(most, 0.0005 * std::sqrt(1.0 + 2.0 / 16.0), 1e-10);
}

TEST_F(Simulate, FilesOfOthersStayWhateverTheirName) {
  SceneText text;
  text.rest = "model: {finite_elements: p1}\n";
  const auto out = fixture_.folder() / "out";
  const std::vector<std::string> words{"simulate", scene(text), "-o", out.string()};
  ASSERT_EQ(run_program(words).exit_code, 0);
  EXPECT_EQ(run_program(words).exit_code, 0) << "results of an earlier run go";
  for (const std::string name : {"history.csv", "frames.pvd", "summary.json", "frame_00007.vtu"}) {
    fixture_.folder().add("out/" + name, "day,value\n");
    const auto refused = run_program(words);
    EXPECT_EQ(refused.exit_code, 2);
    EXPECT_THAT(refused.error, HasSubstr(name + ": expected what an earlier simulate has written"));
    EXPECT_EQ(test::bytes_of(out / name), "day,value\n");
    EXPECT_TRUE(std::filesystem::exists(out / "displacement.csv"));
    std::filesystem::remove(out / name);
  }
}

TEST_F(Simulate, ASummaryOfVeryManyFramesIsOneOfItsOwn) {
  SceneText text;
  text.rest = "model: {finite_elements: p1}\n";
  std::filesystem::create_directories(fixture_.folder() / "out");
  json summary{{"schema", "palpate/motion/1"}, {"files", json::array()}};
  for (int k = 0; k < 5000; ++k)
    summary["files"].push_back("out/frame_" + std::to_string(10000 + k) + ".vtu");
  fixture_.folder().add("out/summary.json", summary.dump(2));
  const auto result = run_program({"simulate", scene(text), "-o", (fixture_.folder() / "out").string()});
  EXPECT_EQ(result.exit_code, 0) << result.error;
  EXPECT_FALSE(std::filesystem::exists(fixture_.folder() / "out/summary.json"));
}

TEST_F(Simulate, TheScenesOwnMeshStays) {
  const auto out = fixture_.folder() / "out";
  const TetMesh mesh = read_medit(fixture_.folder() / "cube.mesh").mesh;
  std::filesystem::create_directories(out);
  write_displacement_vtu(out / "displacement.vtu", mesh, std::vector<Vec3>(mesh.points.size()));
  const std::string before = test::bytes_of(out / "displacement.vtu");
  SceneText text;
  text.mesh = "{file: out/displacement.vtu, length_m: 0.1}";
  text.rest = "model: {finite_elements: p1}\n";
  const auto refused = run_program({"simulate", scene(text), "-o", out.string()});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.error,
              HasSubstr("--output: expected another folder than that of what the scene reads"));
  EXPECT_EQ(test::bytes_of(out / "displacement.vtu"), before);
}

TEST_F(Simulate, ParaViewsFileHoldsTheMesh) {
  const TetMesh mesh = read_medit(fixture_.folder() / "cube.mesh").mesh;
  const std::vector<Vec3> field(mesh.points.size(), Vec3{0.5, 0.25, -0.125});
  write_displacement_vtu(fixture_.folder() / "d.vtu", mesh, field);
  EXPECT_EQ(read_mesh(fixture_.folder() / "d.vtu").mesh, mesh);
  EXPECT_THAT(test::bytes_of(fixture_.folder() / "d.vtu"), HasSubstr("0.5 0.25 -0.125\n"));
}

TEST_F(Simulate, WhatCannotBeDoneIsSaid) {
  const std::string out = (fixture_.folder() / "out").string();
  SceneText text;
  auto result = run_program({"simulate", scene(text), "-o", out});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.error, HasSubstr("the key \"model\" is missing"));
  text.rest = "model: {springs: isotropi}\n";
  result = run_program({"simulate", scene(text), "-o", out});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.error, HasSubstr("unknown method \"springs.isotropi\""));
  text.rest = "model: {finite_elements: p1, thickness: 3}\n";
  result = run_program({"simulate", scene(text), "-o", out});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.error, HasSubstr("fem.p1 has no option \"thickness\""));
  text.rest = "model: {finite_elements: p1}\n";
  text.analysis = "{dynamic: {integrator: symplectic_euler, time_step_s: 0.1, duration_s: 1}}";
  result = run_program({"simulate", scene(text), "-o", out});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.error, HasSubstr("fem.p1 solves static scenes alone"));
  text.analysis = "static";
  text.clamp = "[]";
  result = run_program({"simulate", scene(text), "-o", out});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.error, HasSubstr("the clamps leave every rigid motion free"));
  EXPECT_FALSE(std::filesystem::exists(fixture_.folder() / "out/displacement.csv"));
}

TEST_F(Simulate, CheckReadsScenesAndPutsThemOnTheirMesh) {
  SceneText text;
  text.rest = "model: {finite_elements: p2}\n";
  auto result = run_program({"check", scene(text)});
  EXPECT_EQ(result.exit_code, 0) << result.error;
  EXPECT_THAT(result.out, HasSubstr("scene.yaml: good, a static scene of 125 vertices"));
  text.load = "[{force: {sphere: {center_m: [0.05, 0.05, 0.05], radius_m: 0.01}, total_n: [1, 0, 0]}}]";
  result = run_program({"check", scene(text)});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.error, HasSubstr("selects nothing"));
}

}  // namespace
}  // namespace palpate::experiments

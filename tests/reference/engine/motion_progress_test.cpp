// What is said of a motion while it runs.
#include "reference/engine/motion_progress.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/mesh/shapes/shapes.h"
#include "tests/support/scratch_folder.h"

namespace palpate::reference {
namespace {

TEST(MotionProgressFile, TheFlattestTetAtAVertex) {
  // Tets of a Kuhn cube of side 1 with their longest edge as the diagonal: 3 V / A = (3 / 6) / (sqrt(2) / 2).
  TetMesh mesh = build_kuhn_cube(2, 0.0, 0);
  FlatTet flat = find_flattest_tet(mesh, 13);
  EXPECT_NEAR(flat.height_m, 0.5 * std::sqrt(0.5), 1e-12);
  EXPECT_NEAR(flat.median_height_m, flat.height_m, 1e-12);
  // Another vertex on its way to a face of a tet makes that one flat.
  const Tet& chosen = mesh.tets[5];
  const Vec3 middle =
      (1.0 / 3.0) * (mesh.points[chosen[1]] + mesh.points[chosen[2]] + mesh.points[chosen[3]]);
  mesh.points[chosen[0]] = middle + 0.01 * (mesh.points[chosen[0]] - middle);
  flat = find_flattest_tet(mesh, chosen[0]);
  EXPECT_LT(flat.height_m, 0.01);
  EXPECT_GT(flat.median_height_m, 0.1);
}

TEST(MotionProgressFile, IsThereBeforeTheFirstStep) {
  const test::ScratchFolder folder;
  const TetMesh mesh = build_kuhn_cube(2, 0.0, 0);
  MotionSetup setup;
  setup.step_s = 0.001;
  setup.steps = 500;
  setup.stable.step_s = 0.0011;
  setup.stable_by = "eigenvalues";
  setup.stable.limiting_vertex = 13;
  const MotionProgress progress(folder / "progress.json", setup, mesh);
  const nlohmann::json said = nlohmann::json::parse(test::bytes_of(folder / "progress.json"));
  EXPECT_EQ(said.at("schema"), "palpate/progress/1");
  EXPECT_EQ(said.at("steps"), 500);
  EXPECT_EQ(said.at("steps_done"), 0);
  EXPECT_EQ(said.at("limiting").at("vertex"), 13);
  EXPECT_EQ(said.at("limiting").at("place_m"), (nlohmann::json{0.5, 0.5, 0.5}));
  setup.stable.limiting_vertex = kNoIndex;
  const MotionProgress implicit(folder / "implicit.json", setup, mesh);
  EXPECT_TRUE(nlohmann::json::parse(test::bytes_of(folder / "implicit.json")).at("limiting").is_null());
}

TEST(MotionProgressFile, SaysWhatIsPreparedUntilTheStepsBegin) {
  const test::ScratchFolder folder;
  const auto file = folder / "progress.json";
  ProgressFile progress(file);
  progress.stage("modes");
  const nlohmann::json first = nlohmann::json::parse(test::bytes_of(file));
  EXPECT_EQ(first.at("schema"), "palpate/progress/1");
  EXPECT_EQ(first.at("stage"), "modes");
  EXPECT_FALSE(first.contains("steps_done"));
  progress.begin({{"steps", 7}});
  const nlohmann::json then = nlohmann::json::parse(test::bytes_of(file));
  EXPECT_FALSE(then.contains("stage"));
  EXPECT_EQ(then.at("steps_done"), 0);
  EXPECT_GE(then.at("seconds").get<double>(), first.at("seconds").get<double>());
}

TEST(MotionProgressFile, NoFileIsNoFailure) {
  const test::ScratchFolder folder;
  const TetMesh mesh = build_kuhn_cube(1, 0.0, 0);
  MotionProgress none({}, MotionSetup(), mesh);
  none.reach(10);
  MotionProgress nowhere(folder / "no" / "such" / "progress.json", MotionSetup(), mesh);
  nowhere.reach(10);
  EXPECT_EQ(folder.count(), 0U);
}

}  // namespace
}  // namespace palpate::reference

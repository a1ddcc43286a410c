// Bullet's soft body through its door: it keeps momentum, moves towards its rest lengths and refuses
// nonsense.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "core/dynamics/motion_model.h"
#include "core/mesh/medit.h"
#include "core/mesh/shapes.h"
#include "core/mesh/topology.h"
#include "experiments/contestant_run.h"
#include "tests/support/scratch_folder.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;
using testing::HasSubstr;

class BulletBody : public testing::Test {
 protected:
  void SetUp() override { ASSERT_EQ(registry_.find("bullet.soft_body")->contestant->unavailable(), ""); }

  ContestantAnswer run(const TetMesh& mesh, const json& options) {
    const auto folder = scratch_ / std::to_string(++asked_);
    std::filesystem::create_directory(folder);
    ContestantTask task;
    task.method = *registry_.find("bullet.soft_body");
    task.mesh_in = folder / "in.mesh";
    write_medit(task.mesh_in, mesh);
    task.scratch = folder / "scratch";
    std::filesystem::create_directory(task.scratch);
    task.options = options;
    task.timeout_s = 60.0;
    return run_contestant(task);
  }

  Registry registry_ = load_registry();
  test::ScratchFolder scratch_;
  int asked_ = 0;
};

Vec3 center_of_mass(const TetMesh& mesh, const std::vector<double>& mass_kg) {
  Vec3 sum;
  double total = 0.0;
  for (std::size_t v = 0; v < mass_kg.size(); ++v) {
    sum = sum + mass_kg[v] * mesh.points[v];
    total += mass_kg[v];
  }
  return (1.0 / total) * sum;
}

/// Root mean square of the edges' strains.
double strain(const TetMesh& rest, const TetMesh& moved) {
  double sum = 0.0;
  const std::vector<Edge> edges = build_edges(rest);
  for (const Edge& e : edges) {
    const double before = length(rest.points[e[1]] - rest.points[e[0]]);
    const double after = length(moved.points[e[1]] - moved.points[e[0]]);
    sum += (after / before - 1.0) * (after / before - 1.0);
  }
  return std::sqrt(sum / static_cast<double>(edges.size()));
}

TEST_F(BulletBody, AnswersWithItsTimeAndAMeshThatMoved) {
  const TetMesh mesh = build_kuhn_cube(4, 0.2, 3);
  const ContestantAnswer answer = run(mesh, {{"steps", 50}, {"speed_m_s", 0.5}});
  ASSERT_EQ(answer.outcome, "ok") << answer.message;
  EXPECT_EQ(answer.report.at("springs"), build_edges(mesh).size());
  EXPECT_EQ(answer.report.at("steps"), 50);
  ASSERT_EQ(answer.notes.size(), 1U);
  EXPECT_THAT(answer.notes[0], HasSubstr("not springs in N/m"));
  const TetMesh moved = read_medit(answer.output, ReadOrientation::kKeep).mesh;
  ASSERT_EQ(moved.points.size(), mesh.points.size());
  EXPECT_EQ(moved.tets, mesh.tets);
  EXPECT_GT(strain(mesh, moved), 0.0);
}

TEST_F(BulletBody, LinksHoldTheirLengthsAndKeepMomentum) {
  const TetMesh mesh = build_kuhn_cube(4, 0.2, 3);
  // Forces inside the body don't move its centre: it flies on with the velocity it had. The velocities are
  // the same in both runs, so twice the steps take it twice as far.
  const std::vector<double> mass_kg = dynamics::build_lumped_masses(mesh, 1000.0);
  const auto fly = [&](int steps, int iterations) {
    const ContestantAnswer answer =
        run(mesh, {{"steps", steps}, {"iterations", iterations}, {"time_step_s", 1e-3}, {"speed_m_s", 1.0}});
    EXPECT_EQ(answer.outcome, "ok") << answer.message;
    return read_medit(answer.output, ReadOrientation::kKeep).mesh;
  };
  const TetMesh once = fly(100, 1);
  const TetMesh twice = fly(200, 1);
  const Vec3 start = center_of_mass(mesh, mass_kg);
  const Vec3 first = center_of_mass(once, mass_kg) - start;
  const Vec3 second = center_of_mass(twice, mass_kg) - start;
  // Single precision: each of 200 steps rounds positions of size 1 to 6e-8.
  EXPECT_LT(length(second - 2.0 * first), 200 * 6e-8);
  EXPECT_GT(length(first), 1e-3);
  // Without links nodes of 1 m/s along each axis would be 0.1 m apart after 0.1 s, edges being 0.25 m long.
  EXPECT_LT(strain(mesh, fly(100, 10)), 0.1);
}

TEST_F(BulletBody, NonsenseIsRefused) {
  const TetMesh mesh = build_kuhn_cube(1, 0.0, 1);
  EXPECT_EQ(run(mesh, {{"steps", 0}}).outcome, "bad_input");
  EXPECT_EQ(run(mesh, {{"time_step_s", -1.0}}).outcome, "bad_input");
  EXPECT_EQ(run(mesh, {{"stiffness", 2.0}}).outcome, "bad_input");
  const ContestantAnswer unknown = run(mesh, {{"sweeps", 1}});
  EXPECT_EQ(unknown.outcome, "bad_input");
  EXPECT_THAT(unknown.message, HasSubstr("sweeps"));
}

}  // namespace
}  // namespace palpate::experiments

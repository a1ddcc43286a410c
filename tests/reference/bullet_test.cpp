// Bullet's soft body through its door: it keeps momentum, moves towards its rest lengths and refuses
// nonsense. Bullet's springs: the force of one in closed form, and the motion of a body against our own
// engine.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "core/dynamics/motion/motion_model.h"
#include "core/mesh/io/medit.h"
#include "core/mesh/shapes/shapes.h"
#include "core/mesh/topology.h"
#include "experiments/contestants/contestant_run.h"
#include "experiments/registry/registry.h"
#ifdef PALPATE_HAS_BULLET
#include "reference/bullet/mass_springs.h"
#endif
#include "tests/support/dynamics_cases.h"
#include "tests/support/motion_cases.h"
#include "tests/support/scratch_folder.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;
using testing::HasSubstr;

class BulletBody : public testing::Test {
 protected:
  void SetUp() override { ASSERT_EQ(registry_.find("bullet.soft_body")->contestant->unavailable(), ""); }

  ContestantAnswer run(const TetMesh& mesh, const json& options,
                       const std::string& method = "bullet.soft_body") {
    const auto folder = scratch_ / std::to_string(++asked_);
    std::filesystem::create_directory(folder);
    ContestantTask task;
    task.method = *registry_.find(method);
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

TEST_F(BulletBody, MassSpringsAnswerToo) {
  const TetMesh mesh = build_kuhn_cube(2, 0.2, 3);
  json options = {
      {"steps", 50}, {"speed_m_s", 0.5}, {"stiffness_n_per_m", 1000.0}, {"damping_n_s_per_m", 1.0}};
  const ContestantAnswer answer = run(mesh, options, "bullet.mass_springs");
  ASSERT_EQ(answer.outcome, "ok") << answer.message;
  EXPECT_TRUE(answer.notes.empty());
  EXPECT_EQ(answer.report.at("springs"), build_edges(mesh).size());
  EXPECT_GT(strain(mesh, read_medit(answer.output, ReadOrientation::kKeep).mesh), 0.0);
  options["stiffness_n_per_m"] = 1e12;
  const ContestantAnswer apart = run(mesh, options, "bullet.mass_springs");
  EXPECT_EQ(apart.outcome, "bad_input");
  EXPECT_THAT(apart.message, HasSubstr("stays finite"));
  EXPECT_EQ(run(mesh, {{"iterations", 1}}, "bullet.mass_springs").outcome, "bad_input");
}

#ifdef PALPATE_HAS_BULLET
/// Two nodes, 0.25 m apart at rest, moved to `apart`; all in single precision.
reference::BulletSprings one_spring(const Vec3& apart, double stiffness_n_per_m, double damping_n_s_per_m) {
  const std::vector<Vec3> points{{0.0, 0.0, 0.0}, apart};
  SpringNetwork net;
  net.springs = {{0, 1}};
  net.rest_length_m = {0.25};
  return {points, net, std::vector<double>{2.0, 1.0}, {stiffness_n_per_m, damping_n_s_per_m}};
}

// k (|d| - L) n in N/m: 40 N/m over 0.3 m, 0.05 m too long, are 2 N along (2, 1, 2) / 3.
TEST(BulletSprings, HaveAStiffnessInNewtonsPerMetre) {
  reference::BulletSprings body = one_spring({0.2, 0.1, 0.2}, 40.0, 0.0);
  const std::vector<Vec3> force = body.forces();
  const Vec3 wanted{4.0 / 3.0, 2.0 / 3.0, 4.0 / 3.0};
  constexpr double kRounding = 2e-5;  // 0.3 - 0.25 in single precision
  EXPECT_LT(length(force[0] - wanted), kRounding);
  EXPECT_LT(length(force[1] + wanted), kRounding);
  body.step(0.01);
  const std::vector<Vec3> at = body.positions();
  EXPECT_LT(length(at[0] - (0.01 * 0.01 / 2.0) * wanted), 1e-8);
  EXPECT_LT(length(at[1] - Vec3{0.2, 0.1, 0.2} + (0.01 * 0.01) * wanted), 3e-8);
}

// c (w . n) n: what moves across the spring is not held.
TEST(BulletSprings, DampAlongTheSpringAlone) {
  reference::BulletSprings body = one_spring({0.25, 0.0, 0.0}, 40.0, 3.0);
  body.set_velocities(std::vector<Vec3>{{0.0, 1.0, 0.0}, {2.0, -5.0, 7.0}});
  const std::vector<Vec3> force = body.forces();
  EXPECT_LT(length(force[0] - Vec3{6.0, 0.0, 0.0}), 1e-5);
  EXPECT_LT(length(force[1] + Vec3{6.0, 0.0, 0.0}), 1e-5);
}

// A body whose springs have one stiffness moves as our engine of every force has it, in double precision.
TEST(BulletSprings, MoveABodyAsOurEngineDoes) {
  constexpr int kSteps = 100;
  constexpr double kStep = 2e-3;
  dynamics::MotionModel model = testing_support::make_free_body(build_kuhn_cube(3, 0.2, 5), 1e-3);
  std::fill(model.elastic.springs.stiffness_n_per_m.begin(), model.elastic.springs.stiffness_n_per_m.end(),
            300.0);
  std::fill(model.spring_damping_n_s_per_m.begin(), model.spring_damping_n_s_per_m.end(), 0.5);
  reference::BulletSprings body(model.elastic.rest, model.elastic.springs, model.mass_kg, {300.0, 0.5});
  dynamics::MotionState state = dynamics::start_at_rest(model);
  state.velocity_m_s = testing_support::make_random_field(model.mass_kg.size(), 0.5, 2);
  body.set_velocities(state.velocity_m_s);
  for (int k = 0; k < kSteps; ++k) body.step(kStep);
  state = testing_support::march(model, {}, state, kSteps * kStep, kSteps);
  const std::vector<Vec3> at = body.positions();
  double farthest = 0.0;
  double moved = 0.0;
  for (std::size_t v = 0; v < at.size(); ++v) {
    farthest = std::max(farthest, length(at[v] - model.elastic.rest[v] - state.displacement_m[v]));
    moved = std::max(moved, length(state.displacement_m[v]));
  }
  EXPECT_LT(farthest, kSteps * 2.0 * 6e-8);  // each step rounds positions and velocities of size 1
  EXPECT_GT(moved, 0.02);
}
#endif

}  // namespace
}  // namespace palpate::experiments

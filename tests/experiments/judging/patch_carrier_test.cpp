#include "experiments/judging/patch_carrier.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/base/error.h"
#include "core/dynamics/elasticity/loads.h"
#include "core/mesh/geometry.h"
#include "core/mesh/io/medit.h"
#include "core/mesh/shapes/shapes.h"
#include "experiments/scene_reader/scene_problem.h"
#include "reference/door/deform_problem.h"
#include "tests/support/scene_text.h"
#include "tests/support/scratch_folder.h"

namespace palpate::experiments {
namespace {

using test::SceneText;
using testing::HasSubstr;

/// A cube of 0.1 m, of 12^3 cells and of 3^3, held at x <= 0.05 of its bottom and pushed in a disc on its
/// top.
class PatchCarrierTest : public testing::Test {
 protected:
  PatchCarrierTest() {
    write_medit(folder_ / "fine.mesh", fine_);
    write_medit(folder_ / "coarse.mesh", coarse_);
    text_.mesh = "{file: fine.mesh, unit_m: 1}";
    text_.clamp = "[{box: {low_m: [-1, -1, -1], high_m: [0.05, 1, 1.0e-6]}, elastic_pa_per_m: 1.0e6}]";
    text_.load = "[{force: {sphere: {center_m: [0.05, 0.05, 0.1], radius_m: 0.02}, total_n: [0, 0, -2]}}]";
  }

  static TetMesh cube(int cells) {
    TetMesh mesh = build_kuhn_cube(cells, 0.0, 0);
    for (Vec3& p : mesh.points) p = 0.1 * p;
    return mesh;
  }

  Scene read() const { return read_scene(folder_.add("scene.yaml", text_.yaml())); }
  Scene placed() const { return place_scene(read(), fine_); }

  std::string error_of(const std::string& mesh) {
    text_.mesh = mesh;
    try {
      const Scene scene = read();
      place_scene(scene, build_scene_mesh(scene.mesh).mesh);
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  }

  /// What the supports hold against a turn, u = (0, 0, x), in J.
  static double energy_of_turn(const TetMesh& mesh, BoundaryProblem problem) {
    problem.tractions.clear();
    std::vector<Vec3> u;
    for (const Vec3& p : mesh.points) u.push_back({0.0, 0.0, p.x});
    return load_energy(dynamics::build_loads(mesh, problem), u, 1.0);
  }

  TetMesh fine_ = cube(12);
  TetMesh coarse_ = cube(3);
  SceneText text_;
  test::ScratchFolder folder_;
};

TEST_F(PatchCarrierTest, OnTheSameSkinNothingChangesToTheBit) {
  EXPECT_EQ(reference::problem_to_json(build_problem(on_whole(placed(), fine_), fine_)).dump(),
            reference::problem_to_json(build_problem(placed(), fine_)).dump());
}

TEST_F(PatchCarrierTest, ACoarseSkinIsHeldWhereTheFineOneIs) {
  const double truth = energy_of_turn(fine_, build_problem(placed(), fine_));
  EXPECT_NEAR(truth, 0.5 * 1.0e6 * 0.1 * std::pow(0.05, 3) / 3.0, 0.01 * truth)
      << "k / 2 of the integral of x^2";
  const double by_shares = energy_of_turn(coarse_, build_problem(placed(), coarse_));
  const double carried = energy_of_turn(coarse_, build_problem(on_whole(placed(), fine_), coarse_));
  EXPECT_GT(by_shares, 1.2 * truth) << "half of a row of faces reaches to x = 0.067";
  EXPECT_LT(std::fabs(carried - truth), 0.4 * std::fabs(by_shares - truth));
}

TEST_F(PatchCarrierTest, TotalsAreKept) {
  const BoundaryProblem problem = build_problem(on_whole(placed(), fine_), coarse_);
  const dynamics::Loads loads = dynamics::build_loads(coarse_, problem);
  Vec3 force;
  for (const Vec3& f : loads.force_n) force = force + f;
  EXPECT_NEAR(force.z, -2.0, 1e-12);
  const FacePatch& patch = problem.supports.at(0).patch;
  double held = 0.0;
  for (std::size_t f = 0; f < patch.faces.size(); ++f) {
    const Vec3& a = coarse_.points[patch.faces[f][0]];
    EXPECT_GT(patch.weight[f], 0.0);
    EXPECT_LE(patch.weight[f], 1.0);
    held += patch.weight[f] * 0.5 *
            length(cross(coarse_.points[patch.faces[f][1]] - a, coarse_.points[patch.faces[f][2]] - a));
  }
  // In each of 256 parts of a coarse face the support is there or not.
  EXPECT_NEAR(problem.supports[0].stiffness_pa_per_m * held, 1.0e6 * 0.005, 0.04 * 1.0e6 * 0.005);
}

TEST_F(PatchCarrierTest, ASceneMayNameTheMeshThatItsRegionsAreFrom) {
  const Scene whole = placed();
  text_.mesh = "{file: coarse.mesh, unit_m: 1, regions_from: fine.mesh}";
  const Scene scene = read();
  const TetMesh mesh = build_scene_mesh(scene.mesh).mesh;
  EXPECT_EQ(reference::problem_to_json(build_problem(place_scene(scene, mesh), mesh)).dump(),
            reference::problem_to_json(build_problem(on_whole(whole, fine_), mesh)).dump());
  EXPECT_THAT(error_of("{file: coarse.mesh, unit_m: 0.001, regions_from: fine.mesh}"),
              HasSubstr("in metres"));
  EXPECT_THAT(error_of("{file: coarse.mesh, unit_m: 1, regions_from: none.mesh}"), HasSubstr("none.mesh"));
  EXPECT_THAT(error_of("{make: bar, regions_from: fine.mesh}"), HasSubstr("regions_from"));
  TetMesh other = fine_;
  for (Vec3& p : other.points) p = 1000.0 * p;
  write_medit(folder_ / "other.mesh", other);
  EXPECT_THAT(error_of("{file: coarse.mesh, unit_m: 1, regions_from: other.mesh}"),
              HasSubstr("other.mesh: expected the mesh that"));
}

}  // namespace
}  // namespace palpate::experiments

#include "experiments/scene_reader/scene_problem.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/base/error.h"
#include "core/mesh/geometry.h"
#include "core/mesh/io/medit.h"
#include "core/mesh/shapes/shapes.h"
#include "core/mesh/topology.h"
#include "reference/door/deform_problem.h"
#include "tests/support/scene_text.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/small_meshes.h"

namespace palpate::experiments {
namespace {

using test::SceneText;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

/// Scenes over the cube [0, 0.1]^3 m of 4^3 cells, straight Kuhn tets.
class SceneProblem : public testing::Test {
 protected:
  SceneProblem() { write_medit(folder_ / "cube.mesh", build_kuhn_cube(4, 0.0, 0)); }

  Scene read(const SceneText& text) const { return read_scene(folder_.add("scene.yaml", text.yaml())); }

  BoundaryProblem build(const SceneText& text) const {
    const Scene scene = read(text);
    const TetMesh mesh = build_scene_mesh(scene.mesh).mesh;
    return build_problem(place_scene(scene, mesh), mesh);
  }

  std::string error_of(const SceneText& text) const {
    try {
      build(text);
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  }

  static double area(const TetMesh& mesh, const FacePatch& patch) {
    double sum = 0.0;
    for (std::size_t i = 0; i < patch.faces.size(); ++i) {
      const Triangle& f = patch.faces[i];
      const Vec3& a = mesh.points[f[0]];
      sum += patch.weight[i] * 0.5 * length(cross(mesh.points[f[1]] - a, mesh.points[f[2]] - a));
    }
    return sum;
  }

  TetMesh cube() const { return build_scene_mesh(read({}).mesh).mesh; }

  test::ScratchFolder folder_;
};

TEST_F(SceneProblem, MeshesAreInMetres) {
  SceneText text;
  const BoundingBox by_length = bounding_box(cube().points);
  EXPECT_EQ(by_length.high, (Vec3{0.1, 0.1, 0.1}));
  text.mesh = "{file: cube.mesh, unit_m: 0.02}";
  EXPECT_EQ(bounding_box(build_scene_mesh(read(text).mesh).mesh.points).high, (Vec3{0.02, 0.02, 0.02}));
  EXPECT_THROW(build_scene_mesh(read(text).mesh, 500), InputError) << "a file has the vertices that it has";
  text.mesh = "{make: bar, unit_m: 0.02}";
  const TetMesh bar = build_scene_mesh(read(text).mesh, 756).mesh;
  EXPECT_EQ(bar.points.size(), 756U);
  EXPECT_NEAR(bounding_box(bar.points).high.x, 0.08, 1e-15);
}

TEST_F(SceneProblem, InvalidMeshesAreRefusedWithTheirFile) {
  TetMesh mesh = build_kuhn_cube(2, 0.0, 0);
  mesh.tets.push_back(mesh.tets[0]);
  write_medit(folder_ / "cube.mesh", mesh);
  EXPECT_THAT(error_of({}),
              AllOf(HasSubstr("cube.mesh: expected a valid mesh, found tetrahedron 49: the same"),
                    Not(HasSubstr("\n"))));
  const TetMesh tet = testing_support::make_corner_tet();  // two that touch in a vertex alone
  mesh = testing_support::join_meshes(tet, tet);
  for (Vec3& p : std::span(mesh.points).subspan(4)) p = -1.0 * p;
  std::swap(mesh.tets[1][2], mesh.tets[1][3]);
  mesh.tets[1][0] = 0;
  mesh.points.erase(mesh.points.begin() + 4);
  for (std::size_t k = 1; k < 4; ++k) --mesh.tets[1][k];
  write_medit(folder_ / "cube.mesh", mesh);
  EXPECT_THAT(error_of({}), HasSubstr("cube.mesh: expected a valid mesh, found vertex 1"));
}

TEST_F(SceneProblem, AFaceInAPlaneBelongsToItsHalfSpaceAlone) {
  SceneText text;
  text.clamp = "[{half_space: {normal: [0, 0, 1], offset_m: 0}, elastic_pa_per_m: 5}]";
  text.load = "[{force: {half_space: {normal: [0, 0, -1], offset_m: -0.1}, total_n: [0, 0, -2]}}]";
  const BoundaryProblem problem = build(text);
  ASSERT_EQ(problem.supports.size(), 1U);
  EXPECT_EQ(problem.supports[0].patch.faces.size(), 32U);
  EXPECT_NEAR(area(cube(), problem.supports[0].patch), 0.01, 1e-12);
  EXPECT_EQ(problem.supports[0].stiffness_pa_per_m, 5.0);
  ASSERT_EQ(problem.tractions.size(), 1U);
  EXPECT_NEAR(problem.tractions[0].traction_pa.z, -200.0, 1e-9);
  EXPECT_TRUE(problem.held.empty());
}

TEST_F(SceneProblem, TotalsAreKeptAndAreasConvergeWhateverTheMesh) {
  SceneText text;
  text.load = "[{force: {sphere: {center_m: [0.05, 0.05, 0.1], radius_m: 0.03}, total_n: [0.3, 0, -2]}}]";
  const double disc = std::numbers::pi * 0.03 * 0.03;
  const Scene placed = place_scene(read(text), cube());
  for (const int cells : {3, 5, 9}) {
    TetMesh mesh = build_kuhn_cube(cells, 0.0, 0);
    for (Vec3& p : mesh.points) p = 0.1 * p;
    const BoundaryProblem problem = build_problem(placed, mesh);
    const Traction& traction = problem.tractions.at(0);
    const double total = area(mesh, traction.patch);
    // Each face's share is that of 256 parts, of side h/16: the disc's rim cuts at most 2 pi r / (h/16) of
    // them a few times over.
    EXPECT_NEAR(total, disc, 0.05 * disc) << cells;
    EXPECT_NEAR(traction.traction_pa.z * total, -2.0, 1e-12);
    EXPECT_NEAR(traction.traction_pa.x * total, 0.3, 1e-12);
    for (const double weight : traction.patch.weight) {
      EXPECT_GT(weight, 0.0);
      EXPECT_LE(weight, 1.0);
    }
  }
}

TEST_F(SceneProblem, HardClampsHoldTheFacesThatLieInThem) {
  SceneText text;
  text.clamp = "[{half_space: {normal: [0, 0, 1], offset_m: 0.02}}]";  // the first layer ends at 0.025
  text.load = "[{displace: {half_space: {normal: [0, 0, -1], offset_m: -0.1}, by_m: [0, 0, -0.001]}}]";
  const BoundaryProblem problem = build(text);
  ASSERT_EQ(problem.held.size(), 2U);
  EXPECT_EQ(problem.held[0].faces.size(), 32U) << "faces of which only a part lies in it are left out";
  EXPECT_EQ(problem.held[0].by_m, (Vec3{0, 0, 0}));
  EXPECT_EQ(problem.held[1].by_m, (Vec3{0, 0, -0.001}));
  const TetMesh mesh = cube();
  EXPECT_NO_THROW(reference::problem_from_json(reference::problem_to_json(problem), mesh, "problem"));
}

TEST_F(SceneProblem, RegionsByTheMeshBecomeMetres) {
  SceneText text;
  text.clamp = "[{half_space: {normal: [0, 0, 1], share: 0.25}, elastic_pa_per_m: 5}]";
  text.load =
      "[{force: {sphere: {surface_point: {direction: [1, 0, 0]}, radius_relative: 0.2}, total_n: [1, 0, "
      "0]}}]";
  const Scene placed = place_scene(read(text), cube());
  EXPECT_NEAR(placed.clamps[0].region.offset, 0.025, 1e-15);
  const Region& sphere = placed.loads[0].region;
  EXPECT_NEAR(sphere.center.x, 0.1, 1e-14);
  EXPECT_NEAR(sphere.center.y, 0.05, 1e-14);
  EXPECT_NEAR(sphere.center.z, 0.05, 1e-14);
  EXPECT_NEAR(sphere.radius, 0.02, 1e-15);
  EXPECT_FALSE(sphere.surface_direction || sphere.radius_relative || placed.clamps[0].region.share);
}

TEST_F(SceneProblem, AClampOrALoadOnNothing) {
  SceneText text;
  text.clamp =
      "[{sphere: {center_m: [0.05, 0.05, 0.05], radius_m: 0.01}}]";  // inside, where there is no skin
  EXPECT_THAT(error_of(text),
              AllOf(HasSubstr("scene.yaml:4: clamp: the region (sphere)"), HasSubstr("selects nothing")));
  text.clamp = "[{sphere: {center_m: [0.05, 0.05, 0], radius_m: 0.001}}]";  // less than a face
  EXPECT_THAT(error_of(text), HasSubstr("no face of the skin has all three vertices in it"));
  text.clamp = "[{sphere: {center_m: [0.05, 0.05, 0.05], radius_m: 0.01}, elastic_pa_per_m: 1}]";
  EXPECT_THAT(error_of(text), HasSubstr("selects nothing of the skin"));
  text = {};
  text.load = "[{force: {box: {low_m: [0.2, 0, 0], high_m: [0.3, 1, 1]}, total_n: [1, 0, 0]}}]";
  EXPECT_THAT(error_of(text), HasSubstr("scene.yaml:5: force: the region (box) selects nothing"));
  text.load = "[{displace: {sphere: {center_m: [0.05, 0.05, 0.05], radius_m: 0.01}, by_m: [0.01, 0, 0]}}]";
  EXPECT_THAT(error_of(text), HasSubstr("scene.yaml:5: displace: the region (sphere) selects nothing"));
}

TEST_F(SceneProblem, RegionsInAnotherUnit) {
  SceneText text;
  text.load = "[{force: {sphere: {center_m: [50, 50, 100], radius_m: 10}, total_n: [1, 0, 0]}}]";  // mm
  EXPECT_THAT(error_of(text), AllOf(HasSubstr("force: the region (sphere) selects nothing: its border is"),
                                    HasSubstr("is it in metres, and is the mesh's unit right?")));
  text.load = "[{force: {sphere: {center_m: [0.05, 0.05, 0.1], radius_m: 10}, total_n: [1, 0, 0]}}]";
  EXPECT_THAT(error_of(text), HasSubstr("is in the wrong place: its border is"));
  text = {};
  text.clamp = "[{half_space: {normal: [0, 0, 1], offset_m: 50}}]";
  EXPECT_THAT(error_of(text), HasSubstr("is in the wrong place: its border is 49.9 m away"));
  text.mesh = "{file: cube.mesh, length_m: 100}";
  text.clamp =
      "[{box: {low_m: [0, 0, -5], high_m: [0.1, 0.1, 0]}}]";  // the mesh's unit is wrong, not the region's
  EXPECT_THAT(error_of(text), HasSubstr("selects nothing"));
}

TEST_F(SceneProblem, ABodyOfMillimetresTakenForMetresIsSaid) {
  SceneText text;
  text.mesh = "{file: cube.mesh, unit_m: 112}";  // a cube of 1
  text.load =
      "[{force: {sphere: {surface_point: {direction: [0.1, 0.2, 1]}, radius_m: 0.015}, total_n: [0, 0, "
      "-1]}}]";
  EXPECT_THAT(error_of(text),
              AllOf(HasSubstr("selects nothing of the skin; with unit_m: 112 the body is 112 m long"),
                    HasSubstr("0.001 for millimetres")));
  const auto notes_of = [&](const std::string& mesh) {
    text.mesh = mesh;
    return build_scene_mesh(read(text).mesh).notes;
  };
  EXPECT_THAT(notes_of("{file: cube.mesh, unit_m: 6}"), testing::Contains(HasSubstr("the body is 6 m long")));
  EXPECT_THAT(notes_of("{file: cube.mesh, length_m: 0.0005}"),
              testing::Contains(HasSubstr("with length_m: 0.0005 the body is 0.0005 m long")));
  EXPECT_TRUE(notes_of("{file: cube.mesh, unit_m: 4.9}").empty());
  EXPECT_TRUE(notes_of("{file: cube.mesh, unit_m: 0.0011}").empty());
}

TEST_F(SceneProblem, ContradictingDisplacements) {
  SceneText text;
  text.load = "[{displace: {half_space: {normal: [0, 0, 1], offset_m: 0}, by_m: [0, 0, 0.001]}}]";
  EXPECT_THAT(error_of(text), AllOf(HasSubstr("scene.yaml:5: displace: contradicts"),
                                    HasSubstr("scene.yaml:4: vertex"), HasSubstr("along z")));
  // The side's lowest edge is clamped along x and y alone: it may be moved along z, and not along y.
  text.clamp = "[{half_space: {normal: [0, 0, 1], offset_m: 0}, axes: [x, y]}]";
  text.load = "[{displace: {half_space: {normal: [1, 0, 0], offset_m: 0}, by_m: [0, 0, 0.001]}}]";
  EXPECT_EQ(error_of(text), "no error");
  text.load = "[{displace: {half_space: {normal: [1, 0, 0], offset_m: 0}, by_m: [0, 0.002, 0]}}]";
  EXPECT_THAT(error_of(text), HasSubstr("is to move by 0.002 m and by 0 m along y"));
}

TEST_F(SceneProblem, RigidMotionsThatAreLeftFree) {
  SceneText text;
  text.clamp = "[]";
  EXPECT_THAT(error_of(text), HasSubstr("the clamps leave every rigid motion free"));
  text.clamp = "[{half_space: {normal: [0, 0, 1], offset_m: 0}, axes: [z]}]";
  const std::string three = error_of(text);
  EXPECT_THAT(three, AllOf(HasSubstr("leave rigid motions free"), HasSubstr("translation along (1, 0, 0)"),
                           HasSubstr("translation along (0, 1, 0)"), HasSubstr("rotation about (0, 0, ")));
  text.clamp = "[{half_space: {normal: [0, 0, 1], offset_m: 0}, axes: [y, z]}]";
  EXPECT_THAT(error_of(text), HasSubstr("leave a rigid motion free: a translation along ("));
  text.clamp =
      "[{half_space: {normal: [0, 0, 1], offset_m: 0}, axes: [z]}, {half_space: {normal: [1, 0, 0], "
      "offset_m: 0}, "
      "axes: [x]}]";
  EXPECT_THAT(error_of(text), HasSubstr("leave a rigid motion free: a translation along ("));
  text.clamp = "[{half_space: {normal: [0, 0, 1], offset_m: 0}, elastic_pa_per_m: 1.0e-3}]";
  EXPECT_EQ(error_of(text), "no error") << "however soft, it holds";
}

TEST_F(SceneProblem, EachPartOfAMeshHasToBeHeld) {
  const TetMesh cube = build_kuhn_cube(4, 0.0, 0);
  write_medit(folder_ / "two.mesh",
              testing_support::join_meshes(cube, testing_support::translated(cube, {2, 0, 0})));
  SceneText text;
  text.mesh = "{file: two.mesh, unit_m: 0.1}";
  EXPECT_EQ(error_of(text), "no error");
  text.clamp = "[{box: {low_m: [0, 0, 0], high_m: [0.1, 0.1, 0]}}]";  // of the first cube alone
  EXPECT_THAT(error_of(text),
              HasSubstr("the clamps leave every rigid motion of the part of the mesh with vertex 125 free"));
}

TEST_F(SceneProblem, TheRayFromTheCentroidLeavesForTheLastTime) {
  // Two cubes far apart as one mesh: the centroid lies between them, outside both.
  const TetMesh cube = build_kuhn_cube(2, 0.0, 0);
  const TetMesh mesh = testing_support::join_meshes(cube, testing_support::translated(cube, {4, 0, 0}));
  SceneText text;
  text.load =
      "[{force: {sphere: {surface_point: {direction: [1, 0.01, 0.02]}, radius_m: 0.4}, total_n: [1, 0, 0]}}]";
  const Scene scene = read(text);
  EXPECT_NEAR(place_region(scene.loads[0].region, mesh).center.x, 5.0, 1e-12);
  text.load =
      "[{force: {sphere: {surface_point: {direction: [0, 1, 0]}, radius_m: 0.4}, total_n: [1, 0, 0]}}]";
  try {
    place_region(read(text).loads[0].region, mesh);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(),
                AllOf(HasSubstr("scene.yaml:5: surface_point"), HasSubstr("the centroid [2.5, 0.5, 0.5]"),
                      HasSubstr("outside the body"), HasSubstr("nearest skin is in the direction")));
  }
}

}  // namespace
}  // namespace palpate::experiments

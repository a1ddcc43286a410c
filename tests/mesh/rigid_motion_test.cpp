#include "core/mesh/rigid_motion.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/mesh/shapes/shapes.h"
#include "core/mesh/topology.h"
#include "tests/support/small_meshes.h"

namespace palpate {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

std::vector<std::string> texts(const TetMesh& mesh, std::span<const std::uint8_t> resisted) {
  std::vector<std::string> all;
  for (const RigidMotion& motion : find_free_motions(mesh, resisted))
    all.push_back(rigid_motion_text(motion));
  return all;
}

std::vector<std::string> texts(const TetMesh& mesh, const BoundaryProblem& problem) {
  return texts(mesh, resisted_axes(mesh, problem));
}

/// Axes (as bits) resisted at each vertex of the unit cube where `holds`.
template <typename Holds>
std::vector<std::uint8_t> resist(const TetMesh& mesh, std::uint8_t axes, Holds&& holds) {
  std::vector<std::uint8_t> resisted(mesh.points.size(), 0);
  for (std::size_t v = 0; v < resisted.size(); ++v) {
    if (holds(mesh.points[v])) resisted[v] = axes;
  }
  return resisted;
}

TEST(RigidMotion, NothingHeldLeavesAllSix) {
  const TetMesh cube = build_kuhn_cube(2, 0.0, 1);
  EXPECT_THAT(
      texts(cube, BoundaryProblem{}),
      ElementsAre("a translation along (1, 0, 0)", "a translation along (0, 1, 0)",
                  "a translation along (0, 0, 1)", "a rotation about (1, 0, 0) through (0.5, 0.5, 0.5) m",
                  "a rotation about (0, 1, 0) through (0.5, 0.5, 0.5) m",
                  "a rotation about (0, 0, 1) through (0.5, 0.5, 0.5) m"));
}

TEST(RigidMotion, AFaceOnRollersSlidesAndSpins) {
  const TetMesh cube = build_kuhn_cube(2, 0.0, 1);
  EXPECT_THAT(texts(cube, resist(cube, 4, [](const Vec3& p) { return p.z == 0.0; })),
              ElementsAre("a translation along (1, 0, 0)", "a translation along (0, 1, 0)",
                          "a rotation about (0, 0, 1) through (0.5, 0.5, 0.5) m"));
  EXPECT_THAT(texts(cube, resist(cube, 6, [](const Vec3& p) { return p.z == 0.0; })),
              ElementsAre("a translation along (1, 0, 0)"));
}

TEST(RigidMotion, AHeldEdgeIsAHinge) {
  const TetMesh cube = build_kuhn_cube(2, 0.0, 1);
  const auto edge = [](const Vec3& p) { return p.x == 1.0 && p.z == 0.0; };
  EXPECT_THAT(texts(cube, resist(cube, 7, edge)),
              ElementsAre("a rotation about (0, 1, 0) through (1, 0.5, 0) m"));
  // On rollers along the edge it may also slide.
  EXPECT_THAT(
      texts(cube, resist(cube, 5, edge)),
      ElementsAre("a translation along (0, 1, 0)", "a rotation about (0, 1, 0) through (1, 0.5, 0) m"));
}

TEST(RigidMotion, AHeldPointIsABallJoint) {
  const TetMesh cube = build_kuhn_cube(2, 0.0, 1);
  const auto free = find_free_motions(cube, resist(cube, 7, [](const Vec3& p) {
                                        return p == Vec3{1, 1, 1};
                                      }));
  ASSERT_EQ(free.size(), 3U);
  for (const RigidMotion& motion : free) {
    EXPECT_TRUE(motion.is_rotation);
    EXPECT_LT(length(cross(motion.axis, Vec3{1, 1, 1} - motion.point)), 1e-12) << "the axis meets the point";
  }
}

TEST(RigidMotion, FramesAndUnitsDoNotMatter) {
  TetMesh cube = build_kuhn_cube(2, 0.0, 1);
  const auto held = resist(cube, 7, [](const Vec3& p) { return p.x == 0.0 && p.y == 0.0; });
  for (Vec3& p : cube.points) p = Vec3{3.0, -2.0, 5.0} + 1e-3 * p;
  EXPECT_THAT(texts(cube, held), ElementsAre("a rotation about (0, 0, 1) through (3, -2, 5.0005) m"));
}

TEST(RigidMotion, FacesResistWhereTheyHold) {
  const TetMesh cube = build_kuhn_cube(2, 0.0, 1);
  BoundaryProblem problem;
  problem.supports.push_back({{{{0, 1, 0}}, {1.0}}, 1.0, {}});
  EXPECT_EQ(texts(cube, problem).size(), 6U) << "a face without an area holds nothing";
  problem.supports[0] = {{build_boundary(cube), {}}, 0.0, {}};
  problem.supports[0].patch.weight.assign(problem.supports[0].patch.faces.size(), 1.0);
  EXPECT_EQ(texts(cube, problem).size(), 6U) << "nor does a support without stiffness";
  problem.supports[0].stiffness_pa_per_m = 1e-12;
  EXPECT_THAT(texts(cube, problem), IsEmpty()) << "however soft, it holds";
  // Held along y on the face y = 0 and along z on the face z = 0, and along x nowhere: x is free; with x held
  // on the face x = 0 too, nothing is.
  problem.supports.clear();
  for (const auto axis : {&Vec3::x, &Vec3::y, &Vec3::z}) {
    HeldFaces held{{}, {axis == &Vec3::x, axis == &Vec3::y, axis == &Vec3::z}, {}};
    for (const Triangle& f : build_boundary(cube)) {
      if (cube.points[f[0]].*axis + cube.points[f[1]].*axis + cube.points[f[2]].*axis == 0.0)
        held.faces.push_back(f);
    }
    problem.held.push_back(held);
  }
  EXPECT_THAT(texts(cube, problem), IsEmpty());
  problem.held.erase(problem.held.begin());
  EXPECT_THAT(texts(cube, problem), ElementsAre("a translation along (1, 0, 0)"));
}

TEST(RigidMotion, EachPartIsLookedAtAlone) {
  const TetMesh tet = testing_support::make_corner_tet();
  TetMesh mesh = testing_support::join_meshes(tet, testing_support::translated(tet, {5, 0, 0}));
  mesh.points.push_back({9, 9, 9});  // of no tet: nothing to hold
  std::vector<std::uint8_t> resisted{7, 7, 7, 0, 0, 0, 0, 0, 0};
  const std::vector<RigidMotion> free = find_free_motions(mesh, resisted);
  ASSERT_EQ(free.size(), 6U);
  for (const RigidMotion& motion : free) EXPECT_EQ(motion.part, 4U);
  resisted[4] = resisted[5] = resisted[6] = 7;
  EXPECT_THAT(find_free_motions(mesh, resisted), IsEmpty());
  EXPECT_THROW(find_free_motions(mesh, std::vector<std::uint8_t>(3)), ContractError);
}

}  // namespace
}  // namespace palpate

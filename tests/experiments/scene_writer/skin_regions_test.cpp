// Where a body rests and where it is pressed, on bodies whose areas are known.
#include "experiments/scene_writer/skin_regions.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/mesh/shapes/shapes.h"
#include "core/mesh/topology.h"

namespace palpate::experiments {
namespace {

/// The box [0, x] x [0, y] x [0, z] of Kuhn cells.
TetMesh box(int cells, const Vec3& size) {
  TetMesh mesh = build_kuhn_cube(cells, 0.0, 0);
  for (Vec3& p : mesh.points) p = {size.x * p.x, size.y * p.y, size.z * p.z};
  return mesh;
}

TEST(SkinRegions, ABoxRestsOnItsFloor) {
  // The floor is 1 of 2 + 4 * 0.1 parts of the skin: more than a fifth, so that the least share is taken.
  const RestingRegion found = find_resting_region(box(10, {0.1, 0.1, 0.01}), {0, 0, 1});
  EXPECT_EQ(found.share, 0.02);
  EXPECT_GE(found.faces, 200U);
  // Of the sides, what lies below 0.02 of the height, in whole sixteenths of a face.
  EXPECT_GE(found.area_share, 1.0 / 2.4 - 1e-9);
  EXPECT_LE(found.area_share, 1.0 / 2.4 + 0.4 / 2.4 * 0.1);
}

TEST(SkinRegions, ATowerRestsOnItsFootToo) {
  // Height 0.4 over a floor of 0.1^2: skin 0.18, floor 0.01, sides 0.4 a metre of height. A fifth of the skin
  // is reached at (0.036 - 0.01) / 0.4 = 0.065, 0.1625 of the height; layers of faces are 1/20 of it high.
  const RestingRegion found = find_resting_region(box(20, {0.1, 0.1, 0.4}), {0, 0, 1});
  EXPECT_NEAR(found.share, 0.1625, 0.05);
  EXPECT_NEAR(found.area_share, 0.2, 0.05);
  EXPECT_NEAR(find_resting_region(box(20, {0.4, 0.1, 0.1}), {1, 0, 0}).share, found.share, 1e-12)
      << "any axis";
}

TEST(SkinRegions, ABodyThatLeansIsHeldUntilItStands) {
  // A tower of 0.1^2 x 0.2 whose top is 0.3 to one side: its centre of mass is 0.1 beside its foot.
  const auto lean = [](double slope) {
    TetMesh mesh = box(10, {0.1, 0.1, 0.2});
    for (Vec3& p : mesh.points) p.x += slope * p.z;
    return mesh;
  };
  const RestingRegion upright = find_resting_region(lean(0.0), {0, 0, 1});
  const RestingRegion leaning = find_resting_region(lean(1.5), {0, 0, 1});
  EXPECT_TRUE(upright.stands);
  EXPECT_TRUE(leaning.stands);
  // It stands once what is held reaches so far that 3/4 of it reach the centre: 3/4 (0.1 + 1.5 z) = 0.2.
  EXPECT_NEAR(leaning.share, (0.2 / 0.75 - 0.1) / 1.5 / 0.2, 0.1 + 1e-9) << "layers are a tenth high";
  EXPECT_GT(leaning.share, upright.share + 0.1);
  // Nothing below 60% of this one reaches far enough.
  EXPECT_FALSE(find_resting_region(lean(4.0), {0, 0, 1}).stands);
}

TEST(SkinRegions, APadLiesOnTop) {
  const TetMesh mesh = box(20, {0.2, 0.2, 0.1});  // a skin of 0.16 m^2
  const PadRegion pad = find_pad_region(mesh, {0, 0, 1});
  ASSERT_TRUE(pad.direction.has_value());
  EXPECT_NEAR(pad.center_m.x, 0.1, 1e-12);
  EXPECT_NEAR(pad.center_m.z, 0.1, 1e-12);
  EXPECT_NEAR(pad.radius_m, 0.0451, 1e-15)
      << "the square root of 4% of the skin over pi, 0.04513 m, to three digits";
  EXPECT_NEAR(pad.area_share, 0.04, 0.003);  // its rim cuts 2 pi r of sixteenths of faces of 10 mm
  EXPECT_NEAR(pad.normal.z, 1.0, 1e-12);
  EXPECT_NEAR(pad.thickness_m, 0.1, 1e-12);
  EXPECT_FALSE(pad.reaches_round);
}

TEST(SkinRegions, APadIsThreeEdgesWideWhereEdgesAreLong) {
  const TetMesh mesh = box(3, {0.1, 0.1, 0.1});
  const PadRegion pad = find_pad_region(mesh, {0, 0, 1});
  EXPECT_NEAR(pad.mean_edge_m, 0.1 / 3.0 * (2.0 + std::numbers::sqrt2) / 3.0, 1e-12);
  EXPECT_GE(pad.radius_m, 0.995 * pad.mean_edge_m);
  EXPECT_LE(pad.radius_m, 1.01 * std::max(0.25 * 0.1, pad.mean_edge_m));
}

TEST(SkinRegions, APadDoesNotReachRoundAThinBody) {
  // 4% of the skin of a leaf would be a pad of radius 16 mm; the leaf is 8 mm thick.
  const PadRegion pad = find_pad_region(box(40, {0.1, 0.1, 0.008}), {0, 0, 1});
  EXPECT_FALSE(pad.reaches_round);
  EXPECT_LE(pad.radius_m, 0.008);
  EXPECT_NEAR(pad.thickness_m, 0.008, 1e-12);
  // With edges longer than that it cannot help it, and says so.
  EXPECT_TRUE(find_pad_region(box(6, {0.1, 0.1, 0.002}), {0, 0, 1}).reaches_round);
}

TEST(SkinRegions, WhereTheRayMeetsNothingThePadIsOnTheHighestFace) {
  // A box with a chimney through its middle: no skin above the centroid.
  TetMesh mesh = box(5, {0.1, 0.1, 0.1});
  std::erase_if(mesh.tets, [&](const Tet& t) {
    Vec3 sum;
    for (const Index v : t) sum = sum + mesh.points[v];
    return std::abs(0.25 * sum.x - 0.05) < 0.01 && std::abs(0.25 * sum.y - 0.05) < 0.01;
  });
  const PadRegion pad = find_pad_region(mesh, {0, 0, 1});
  EXPECT_FALSE(pad.direction.has_value());
  EXPECT_NEAR(pad.center_m.z, 0.1, 1e-12);
  EXPECT_GT(pad.faces, 0U);
}

}  // namespace
}  // namespace palpate::experiments

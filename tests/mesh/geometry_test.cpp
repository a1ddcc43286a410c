#include "core/mesh/geometry.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/mesh/shapes/shapes.h"
#include "core/mesh/topology.h"

namespace palpate {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

/// Quaternion to rotation, applied to p: the columns are orthonormal to rounding.
Vec3 rotated(const Vec3& p, const std::array<double, 4>& q) {
  const auto [w, x, y, z] = q;
  return {(1 - 2 * (y * y + z * z)) * p.x + 2 * (x * y - w * z) * p.y + 2 * (x * z + w * y) * p.z,
          2 * (x * y + w * z) * p.x + (1 - 2 * (x * x + z * z)) * p.y + 2 * (y * z - w * x) * p.z,
          2 * (x * z - w * y) * p.x + 2 * (y * z + w * x) * p.y + (1 - 2 * (x * x + y * y)) * p.z};
}

TEST(Geometry, VolumeOfKnownTets) {
  const Vec3 o{0, 0, 0};
  EXPECT_EQ(signed_volume(o, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}), 1.0 / 6.0);
  EXPECT_EQ(signed_volume(o, {0, 1, 0}, {1, 0, 0}, {0, 0, 1}), -1.0 / 6.0);
  EXPECT_EQ(signed_volume(o, {2, 0, 0}, {0, 3, 0}, {0, 0, 4}), 4.0);
  EXPECT_EQ(signed_volume(o, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}), 0.0);
  // Regular tet of edge sqrt(8): volume l^3 / (6 sqrt 2) = 8 / 3.
  EXPECT_DOUBLE_EQ(signed_volume({1, 1, 1}, {-1, 1, -1}, {1, -1, -1}, {-1, -1, 1}), 8.0 / 3.0);
}

TEST(Geometry, VolumeIsInvariantUnderRotationAndTranslation) {
  const std::uint64_t seed = 5;
  SCOPED_TRACE("seed 5");
  SplitMix64 random(seed);
  const auto number = [&] { return 2.0 * random.uniform() - 1.0; };
  for (int i = 0; i < 1000; ++i) {
    std::array<Vec3, 4> p;
    for (Vec3& v : p) v = {number(), number(), number()};
    std::array<double, 4> q{number(), number(), number(), number()};
    const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    for (double& c : q) c /= norm;
    const Vec3 shift{number(), number(), number()};
    const double before = signed_volume(p[0], p[1], p[2], p[3]);
    for (Vec3& v : p) v = rotated(v, q) + shift;
    // Edges are at most 2 sqrt 3 long: a few dozen roundings of products of three of them.
    EXPECT_NEAR(signed_volume(p[0], p[1], p[2], p[3]), before, 64 * 42 * kEpsilon);
  }
}

TEST(Geometry, VolumesOfShapesAreTheirClosedForms) {
  // Summing n equal parts of V / n loses at most n roundings of V.
  for (const int n : {1, 3, 8}) {
    const double tets = 48.0 * n * n * n + 36.0 * n * n;
    EXPECT_NEAR(total_volume(build_kuhn_cube(n, 0.0, 0)), 1.0, tets * kEpsilon);
    EXPECT_NEAR(total_volume(build_kuhn_cube(n, 0.5, 9)), 1.0, tets * kEpsilon);
    EXPECT_NEAR(total_volume(build_bar(n)), 4.0, 4 * tets * kEpsilon);
    EXPECT_NEAR(total_volume(build_bcc_bar(n)), 4.0, 4 * tets * kEpsilon);
  }
  EXPECT_EQ(total_volume({}), 0.0);
}

TEST(Geometry, EnclosedVolumeIsTheVolumeOfTheTetsInside) {
  for (TetMesh mesh : {build_kuhn_cube(4, 0.3, 1), build_bcc_bar(2)}) {
    for (Vec3& p : mesh.points) p = p + Vec3{100, -50, 20};
    SurfaceMesh surface{mesh.points, build_boundary(mesh)};
    const double volume = total_volume(mesh);
    const double rounding = 4.0 * 120.0 * static_cast<double>(mesh.tets.size()) * kEpsilon;
    EXPECT_NEAR(enclosed_volume(surface), volume, rounding);
    for (Triangle& t : surface.triangles) std::swap(t[0], t[1]);
    EXPECT_NEAR(enclosed_volume(surface), -volume, rounding);
  }
  EXPECT_EQ(enclosed_volume({}), 0.0);
}

TEST(Geometry, IcosahedronVolumeIsItsClosedForm) {
  // 5 (3 + sqrt 5) / 12 l^3 with the circumscribed radius 1: l = 4 / sqrt(10 + 2 sqrt 5).
  const double root = std::sqrt(5.0);
  const double edge = 4.0 / std::sqrt(10.0 + 2.0 * root);
  EXPECT_NEAR(enclosed_volume(build_geodesic_sphere(1)), 5.0 * (3.0 + root) / 12.0 * edge * edge * edge,
              100 * kEpsilon);
}

TEST(Geometry, BoundingBox) {
  const std::vector<Vec3> points{{1, -2, 3}, {-4, 5, -6}, {0, 0, 7}};
  const BoundingBox box = bounding_box(points);
  EXPECT_EQ(box.low, (Vec3{-4, -2, -6}));
  EXPECT_EQ(box.high, (Vec3{1, 5, 7}));
  const BoundingBox none = bounding_box({});
  EXPECT_EQ(none.low, Vec3{});
  EXPECT_EQ(none.high, Vec3{});
}

TEST(Geometry, LongestSideIsAlongAnyAxis) {
  EXPECT_EQ(longest_side({{0, 0, 0}, {3, 1, 2}}), 3.0);
  EXPECT_EQ(longest_side({{0, -4, 0}, {1, 1, 2}}), 5.0);
  EXPECT_EQ(longest_side({{0, 0, -1}, {1, 1, 1}}), 2.0);
  EXPECT_EQ(longest_side({}), 0.0);
}

TEST(Geometry, NearestPointIsTheFirstOfEquallyNearOnes) {
  const std::vector<Vec3> points{{5, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 3}};
  EXPECT_EQ(nearest_point(points, {0, 0, 0}), 1U);
  EXPECT_EQ(nearest_point(points, {0, -0.1, 0}), 2U);
  EXPECT_THROW(nearest_point({}, {}), ContractError);
}

TEST(Geometry, NormalizingCentresAndFillsTheUnitBox) {
  for (const double unit : {1e-9, 1.0, 1e9}) {
    std::vector<Vec3> points = build_bean_surface(6).points;
    for (Vec3& p : points) p = unit * (p + Vec3{100, 200, -300});
    const std::vector<Vec3> before = points;
    const double scale = normalize_to_unit_box(points);
    const BoundingBox box = bounding_box(points);
    // The offset costs relative accuracy: 300 units against a box of 11.
    const double rounding = 1000 * kEpsilon;
    EXPECT_NEAR(box.low.x, -1.0, rounding);
    EXPECT_NEAR(box.high.x, 1.0, rounding);
    EXPECT_NEAR(box.low.y, -box.high.y, rounding);
    EXPECT_NEAR(box.low.z, -box.high.z, rounding);
    EXPECT_LT(box.high.y, 1.0);
    for (std::size_t v = 1; v < points.size(); ++v) {
      EXPECT_NEAR(length(points[v] - points[0]), scale * length(before[v] - before[0]), rounding);
    }
  }
}

TEST(Geometry, NormalizingTwiceChangesNothing) {
  std::vector<Vec3> points{{0, 0, 0}, {8, 2, 0}, {1, 4, 2}};
  EXPECT_EQ(normalize_to_unit_box(points), 0.25);
  const std::vector<Vec3> once = points;
  EXPECT_EQ(points[0], (Vec3{-1, -0.5, -0.25}));
  EXPECT_EQ(normalize_to_unit_box(points), 1.0);
  EXPECT_EQ(points, once);
}

TEST(Geometry, NormalizingNeedsPointsThatDiffer) {
  std::vector<Vec3> same(3, Vec3{1, 2, 3});
  EXPECT_THROW(normalize_to_unit_box(same), InputError);
  EXPECT_THROW(normalize_to_unit_box({}), InputError);
}

}  // namespace
}  // namespace palpate

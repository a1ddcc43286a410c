#include "core/simplify/cover/cover_check.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/base/random.h"
#include "core/judge/surface/surface.h"
#include "tests/support/small_meshes.h"
#include "tests/support/triangle_corners.h"

namespace palpate::simplify {
namespace {

using namespace palpate::testing_support;  // NOLINT(google-build-using-namespace)

TEST(CoverTest, AParallelTriangleIsCoveredFromItsHeightOn) {
  const SurfaceMesh ground{{{-9, -9, 0}, {9, -9, 0}, {0, 9, 0}}, {{0, 1, 2}}};
  const TriangleTree tree(ground.points, ground.triangles);
  const TriangleCorners above{Vec3{0, 0, 0.5}, Vec3{1, 0, 0.5}, Vec3{0, 1, 0.5}};
  EXPECT_TRUE(CoverTest(0.5).is_covered(above, tree));
  EXPECT_FALSE(CoverTest(0.499).is_covered(above, tree));
}

TEST(CoverTest, AHoleBelowIsSeenThoughAllCornersAreCovered) {
  // A ring of four triangles around a square hole; the triangle's corners are over the ring.
  const SurfaceMesh ring{
      {{0, 0, 0}, {8, 0, 0}, {8, 8, 0}, {0, 8, 0}, {2, 2, 0}, {6, 2, 0}, {6, 6, 0}, {2, 6, 0}},
      {{0, 1, 4}, {1, 5, 4}, {1, 2, 5}, {2, 6, 5}, {2, 3, 6}, {3, 7, 6}, {3, 0, 7}, {0, 4, 7}}};
  const TriangleTree tree(ring.points, ring.triangles);
  const TriangleCorners over{Vec3{1, 1, 0}, Vec3{7, 1, 0}, Vec3{4, 7, 0}};
  EXPECT_FALSE(CoverTest(1.0).is_covered(over, tree));
  EXPECT_TRUE(CoverTest(2.01).is_covered(over, tree));  // 2 to the sides from the middle
}

TEST(CoverTest, NamesTheTrianglesThatAreEnough) {
  const std::vector<BoxedTriangle> by{BoxedTriangle({Vec3{0, 0, 0}, Vec3{4, 0, 0}, Vec3{0, 4, 0}}),
                                      BoxedTriangle({Vec3{4, 0, 0}, Vec3{4, 4, 0}, Vec3{0, 4, 0}}),
                                      BoxedTriangle({Vec3{90, 0, 0}, Vec3{91, 0, 0}, Vec3{90, 1, 0}})};
  std::vector<Index> used;
  CoverTest test(1e-12);  // corners that are cut out are rounded
  EXPECT_TRUE(test.is_covered(BoxedTriangle({Vec3{1, 1, 0}, Vec3{3, 3, 0}, Vec3{1, 2, 0}}), by, used));
  std::sort(used.begin(), used.end());
  EXPECT_EQ(used, (std::vector<Index>{0, 1}));
}

TEST(CoverTest, PointsNearAShortListAreThoseNearOneOfIt) {
  SplitMix64 random(5);
  const auto place = [&] { return Vec3{random.uniform(), random.uniform(), random.uniform()}; };
  for (int round = 0; round < 200; ++round) {
    SurfaceMesh surface;
    std::vector<BoxedTriangle> list;
    for (Index i = 0; i < 6; ++i) {
      TriangleCorners t{place(), place(), place()};
      if (i == 4) t[2] = 0.3 * t[0] + 0.7 * t[1];  // flat but for rounding: its plane says nothing
      if (i == 5) t[1] = t[2] = t[0];
      for (const Vec3& p : t) surface.points.push_back(p);
      surface.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
      list.emplace_back(t);
    }
    const TriangleTree tree(surface.points, surface.triangles);
    const Vec3 p = place();
    double least = 1e300;
    for (const BoxedTriangle& b : list) {
      // Every side counts here, whichever the point is beyond.
      const TriangleCorners& t = b.corner;
      double here = distance_sq_to_triangle(p, t[0], t[1], t[2]);
      for (std::size_t k = 0; k < 3; ++k)
        here = std::min(here, distance_sq_to_segment(p, t[k], t[(k + 1) % 3]));
      EXPECT_NEAR(distance_sq_to_triangle(p, t[0], t[1], t[2]), here, 1e-14);
      least = std::min(least, here);
    }
    for (const double factor : {0.9, 0.999, 1.001, 1.1}) {
      const CoverTest test(factor * std::sqrt(least));
      EXPECT_EQ(test.is_near(p, list), factor > 1.0) << "round " << round;
      EXPECT_EQ(test.is_near(p, tree), factor > 1.0) << "round " << round;
    }
  }
}

TEST(CoverTest, NeverSaysYesAgainstTheJudgeAndSeldomNo) {
  std::size_t yes = 0;
  std::size_t no = 0;
  std::size_t too_careful = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    SplitMix64 random(seed);
    const SurfaceMesh one = random_triangles(1, 0.5, random);
    const SurfaceMesh others = random_triangles(25, seed % 2 == 0 ? 0.3 : 1.0, random);
    const judge::SurfaceDistance exact = judge::measure_surface_distance(one, others);
    const TriangleTree tree(others.points, others.triangles);
    for (const double factor : {0.8, 0.99, 1.01, 1.2}) {
      const double limit = factor * exact.forward.upper;
      CoverTest test(limit);
      const bool is_covered = test.is_covered(triangle_corners(one, 0), tree);
      EXPECT_TRUE(!is_covered || (test.reach() >= exact.forward.lower && test.reach() <= limit))
          << "seed " << seed;
      if (!is_covered && factor > 1.1) ++too_careful;
      ++(is_covered ? yes : no);
    }
  }
  EXPECT_GT(yes, 60U);
  EXPECT_GT(no, 60U);
  EXPECT_LE(too_careful, 3U);
}

}  // namespace
}  // namespace palpate::simplify

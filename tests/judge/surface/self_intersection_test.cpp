#include <gtest/gtest.h>

#include <limits>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/judge/surface/surface.h"
#include "core/mesh/shapes/shapes.h"
#include "tests/support/cgal_oracle.h"
#include "tests/support/full_mode.h"
#include "tests/support/small_meshes.h"

namespace palpate::judge {
namespace {

using namespace palpate::testing_support;  // NOLINT(google-build-using-namespace)

/// Two triangles, no vertex shared.
SurfaceMesh make_pair(const std::array<Vec3, 3>& a, const std::array<Vec3, 3>& b) {
  return {{a[0], a[1], a[2], b[0], b[1], b[2]}, {{0, 1, 2}, {3, 4, 5}}};
}

constexpr std::array<Vec3, 3> kGround{{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}}};

TEST(SelfIntersections, NoneInGoodSurfaces) {
  EXPECT_EQ(count_self_intersections(build_geodesic_sphere(8)), 0U);
  EXPECT_EQ(count_self_intersections(build_bean_surface(8)), 0U);
  EXPECT_EQ(count_self_intersections(build_boundary(make_cube_ring())), 0U);
  EXPECT_EQ(count_self_intersections(build_boundary(make_hollow_cube())), 0U);
  EXPECT_EQ(count_self_intersections({}), 0U);
}

TEST(SelfIntersections, CountingEndsAtAMillion) {
  const auto pairs_of = [](Index copies) {
    SurfaceMesh same;  // every two of them overlap
    for (Index i = 0; i < copies; ++i) {
      same.points.insert(same.points.end(), kGround.begin(), kGround.end());
      same.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    return count_self_intersections(same);
  };
  EXPECT_EQ(pairs_of(200), 200U * 199U / 2U);
  EXPECT_EQ(pairs_of(1500), kMostSelfIntersections);
  if (!test::is_full()) return;
  EXPECT_EQ(pairs_of(1400), 1400U * 1399U / 2U);
  EXPECT_EQ(pairs_of(4000), kMostSelfIntersections);
}

TEST(SelfIntersections, TwoTrianglesApart) {
  const auto count = [](const std::array<Vec3, 3>& other) {
    const std::uint64_t found = count_self_intersections(make_pair(kGround, other));
    EXPECT_EQ(found, count_self_intersections(make_pair(other, kGround)));
    return found;
  };
  EXPECT_EQ(count({{{1, 1, -1}, {1, 1, 1}, {2, 1, 1}}}), 1U);       // pierced
  EXPECT_EQ(count({{{1, 1, 1}, {1, 2, 1}, {2, 1, 1}}}), 0U);        // above
  EXPECT_EQ(count({{{1, 1, 0}, {1, 1, 1}, {2, 1, 1}}}), 1U);        // a corner on the inside
  EXPECT_EQ(count({{{4, 0, 0}, {5, 0, 1}, {5, 1, 1}}}), 1U);        // corner on corner
  EXPECT_EQ(count({{{2, 2, 0}, {5, 5, 1}, {5, 5, 2}}}), 1U);        // corner on side
  EXPECT_EQ(count({{{2, 0, -1}, {2, 0, 1}, {2, -1, 0}}}), 1U);      // side on side
  EXPECT_EQ(count({{{1, 1, 0}, {2, 1, 0}, {1, 2, 0}}}), 1U);        // in the plane, inside
  EXPECT_EQ(count({{{-9, -9, 0}, {30, -9, 0}, {-9, 30, 0}}}), 1U);  // in the plane, around
  EXPECT_EQ(count({{{-1, 1, 0}, {-1, 2, 0}, {9, 1, 0}}}), 1U);      // in the plane, across
  EXPECT_EQ(count({{{4, 0, 0}, {8, 0, 0}, {8, 4, 0}}}), 1U);        // in the plane, corner on corner
  EXPECT_EQ(count({{{3, 3, 0}, {8, 3, 0}, {8, 8, 0}}}), 0U);        // in the plane, apart
  EXPECT_EQ(count({{{3, 3, -1}, {3, 3, 1}, {8, 8, 1}}}), 0U);       // through the plane, beside it
}

TEST(SelfIntersections, SharedVerticesAndEdgesDoNotCountThemselves) {
  SurfaceMesh surface{{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {2, -1, 0}, {3, 3, 3}, {1, 1, 0}}, {{0, 1, 2}}};
  const auto count_with = [&](const Triangle& t) {
    surface.triangles.resize(1);
    surface.triangles.push_back(t);
    return count_self_intersections(surface);
  };
  EXPECT_EQ(count_with({1, 0, 3}), 0U);  // a flat wing
  EXPECT_EQ(count_with({1, 0, 4}), 0U);  // a wing upwards
  EXPECT_EQ(count_with({1, 0, 5}), 1U);  // folded onto the other
  EXPECT_EQ(count_with({2, 1, 0}), 1U);  // the same triangle again
  EXPECT_EQ(count_with({2, 4, 5}), 1U);  // from a shared vertex to the inside
  EXPECT_EQ(count_with({0, 3, 4}), 0U);  // a shared vertex only; the plane is met outside
  EXPECT_EQ(count_with({0, 3, 5}), 1U);  // in the plane, the fans overlap
  EXPECT_EQ(count_with({5, 5, 4}), 1U);  // without area
}

TEST(SelfIntersections, FindsAMeshOfGoodTetsThatRunsThroughItself) {
  const TetMesh block = make_kuhn_block(2, 2, 2);
  const TetMesh twice = join_meshes(block, translated(block, {1.5, 0.25, 0.25}));
  EXPECT_GT(count_self_intersections(build_boundary(twice)), 0U);
  const TetMesh apart = join_meshes(block, translated(block, {2.5, 0.25, 0.25}));
  EXPECT_EQ(count_self_intersections(build_boundary(apart)), 0U);
  const TetMesh touching = join_meshes(block, translated(block, {2.0, 0.0, 0.0}));
  EXPECT_GT(count_self_intersections(build_boundary(touching)), 0U);
}

/// Small whole coordinates: touching and coplanar cases abound, and all is exact.
SurfaceMesh random_soup(int triangles, SplitMix64& random) {
  SurfaceMesh soup;
  const auto coordinate = [&] { return static_cast<double>(random.below(7)); };
  while (soup.triangles.size() < static_cast<std::size_t>(triangles)) {
    const std::array<Vec3, 3> corner{Vec3{coordinate(), coordinate(), coordinate()},
                                     Vec3{coordinate(), coordinate(), coordinate()},
                                     Vec3{coordinate(), coordinate(), coordinate()}};
    if (length_sq(cross(corner[1] - corner[0], corner[2] - corner[0])) == 0.0) continue;
    const auto first = static_cast<Index>(soup.points.size());
    soup.points.insert(soup.points.end(), corner.begin(), corner.end());
    soup.triangles.push_back({first, first + 1, first + 2});
  }
  return soup;
}

TEST(SelfIntersections, AgreesWithCgalOnTrianglesThatShareNothing) {
  std::uint64_t found = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SplitMix64 random(seed);
    const SurfaceMesh soup = random_soup(40, random);
    const std::uint64_t count = count_self_intersections(soup);
    EXPECT_EQ(count, test::count_self_intersections(soup)) << "seed " << seed;
    found += count;
  }
  EXPECT_GT(found, 100U);
}

TEST(SelfIntersections, AgreesWithCgalOnCrumpledSpheres) {
  std::uint64_t found = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SplitMix64 random(seed);
    SurfaceMesh sphere = build_geodesic_sphere(3);
    const double step = seed % 2 == 0 ? 4.0 : 1024.0;  // coarse steps make coplanar pairs
    const double size = 0.2 * static_cast<double>(1 + seed % 5);
    for (Vec3& p : sphere.points) {
      for (double* x : {&p.x, &p.y, &p.z}) *x = std::round(step * (*x + size * (random.uniform() - 0.5)));
    }
    const std::uint64_t count = count_self_intersections(sphere);
    EXPECT_EQ(count, test::count_self_intersections(sphere)) << "seed " << seed;
    found += count;
  }
  EXPECT_GT(found, 100U);
}

TEST(SelfIntersections, ExactAtTheLastBitAndAtAnySize) {
  for (const double scale : {1e-300, 1.0, 1e300}) {
    SurfaceMesh pair = make_pair(kGround, {{{1, 1, 1}, {1, 2, 1}, {2, 1, 1}}});
    for (Vec3& p : pair.points) p = scale * p;
    pair.points[3].z = std::numeric_limits<double>::denorm_min();
    EXPECT_EQ(count_self_intersections(pair), 0U) << scale;
    pair.points[3].z = 0.0;
    EXPECT_EQ(count_self_intersections(pair), 1U) << scale;
  }
}

TEST(SelfIntersections, RefusesBrokenArrays) {
  SurfaceMesh pair = make_pair(kGround, kGround);
  pair.triangles.push_back({0, 1, 6});
  EXPECT_THROW(count_self_intersections(pair), ContractError);
  pair.triangles.pop_back();
  pair.points[5].x = std::numeric_limits<double>::infinity();
  EXPECT_THROW(count_self_intersections(pair), ContractError);
}

}  // namespace
}  // namespace palpate::judge

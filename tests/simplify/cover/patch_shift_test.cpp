#include "core/simplify/cover/patch_shift.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/random.h"
#include "core/judge/surface/surface.h"
#include "tests/support/triangle_corners.h"

namespace palpate::simplify {
namespace {

using namespace palpate::testing_support;  // NOLINT(google-build-using-namespace)

constexpr Index kRim = 6;

/// Triangles from a point in the middle, the last one, to a rim of six around it.
SurfaceMesh fan_to(const Vec3& middle) {
  SurfaceMesh fan;
  for (Index k = 0; k < kRim; ++k)
    fan.points.push_back({2.0 * std::cos(k * 1.0471975512), 2.0 * std::sin(k * 1.0471975512), 0.0});
  fan.points.push_back(middle);
  for (Index k = 0; k < kRim; ++k) fan.triangles.push_back({k, (k + 1) % kRim, kRim});
  return fan;
}

/// The rim alone, without a point in the middle.
SurfaceMesh flat_hexagon() {
  SurfaceMesh flat = fan_to({});
  flat.triangles = {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}};
  return flat;
}

struct Pair {
  SheetCover sheet;
  std::vector<Tile> gone;
  std::vector<Tile> fresh;
  PatchShift shift;

  Pair(const SurfaceMesh& before, const SurfaceMesh& after, double limit) : sheet(limit) {
    sheet.look_against({0, 0, 1}, {});
    const auto lay = [this](const SurfaceMesh& mesh, std::vector<Tile>& tiles) {
      for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
        tiles.push_back(sheet.tile(mesh.triangles[i], triangle_corners(mesh, i)));
    };
    lay(before, gone);
    lay(after, fresh);
  }

  bool is_known() { return shift.measure(sheet, gone, fresh); }
};

/// How far a face is from some of another mesh's, by the judge: not less than this.
double distance_to(const SurfaceMesh& mesh, std::size_t face, const SurfaceMesh& other,
                   const std::vector<Index>& over) {
  const SurfaceMesh one{mesh.points, {mesh.triangles[face]}};
  SurfaceMesh few{other.points, {}};
  for (const Index i : over) few.triangles.push_back(other.triangles[i]);
  return judge::measure_surface_distance(one, few).forward.lower;
}

TEST(PatchShift, APointThatRisesShiftsEachFaceByAsMuch) {
  const SurfaceMesh before = fan_to({0, 0, 0.1});
  const SurfaceMesh after = fan_to({0, 0, 0.4});
  Pair pair(before, after, 0.31);
  ASSERT_TRUE(pair.is_known());
  for (std::size_t k = 0; k < kRim; ++k) {
    EXPECT_NEAR(pair.shift.of_gone(k).reach, 0.3, 1e-6);
    EXPECT_NEAR(pair.shift.of_fresh(k).reach, 0.3, 1e-6);
    EXPECT_EQ(pair.shift.of_gone(k).over, (std::vector<Index>{static_cast<Index>(k)}));
  }
  EXPECT_FALSE(Pair(before, after, 0.299).is_known());
}

TEST(PatchShift, WhatMovesWithinThePlaneDoesNotShift) {
  Pair pair(fan_to({0, 0, 0}), fan_to({0.5, -0.3, 0}), 1e-3);
  ASSERT_TRUE(pair.is_known());
  for (std::size_t k = 0; k < kRim; ++k) EXPECT_LT(pair.shift.of_gone(k).reach, 1e-6);
}

TEST(PatchShift, NoFaceIsFartherFromThoseOverItByTheJudge) {
  std::size_t known = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    SplitMix64 random(seed);
    const auto place = [&random] {
      return Vec3{2.0 * random.uniform() - 1.0, 2.0 * random.uniform() - 1.0, random.uniform() - 0.5};
    };
    const SurfaceMesh before = fan_to(place());
    const SurfaceMesh after = seed % 2 == 0 ? fan_to(place()) : flat_hexagon();
    Pair pair(before, after, 1.0);
    if (!pair.is_known()) continue;
    ++known;
    for (std::size_t k = 0; k < before.triangles.size(); ++k) {
      const FaceShift& of = pair.shift.of_gone(k);
      EXPECT_LE(distance_to(before, k, after, of.over), of.reach) << "seed " << seed;
    }
    for (std::size_t k = 0; k < after.triangles.size(); ++k) {
      const FaceShift& of = pair.shift.of_fresh(k);
      EXPECT_LE(distance_to(after, k, before, of.over), of.reach) << "seed " << seed;
    }
  }
  EXPECT_GT(known, 150U);
}

TEST(PatchShift, NothingIsKnownWhereASheetHasAHoleOrIsTurnedAway) {
  const SurfaceMesh before = fan_to({0, 0, 0});
  for (Index k = 0; k < kRim; ++k) {
    SurfaceMesh hole = fan_to({0, 0, 0.1});
    hole.triangles.erase(hole.triangles.begin() + k);
    EXPECT_FALSE(Pair(before, hole, 1.0).is_known());
    EXPECT_FALSE(Pair(hole, before, 1.0).is_known());
    SurfaceMesh turned = fan_to({0, 0, 0.1});
    std::swap(turned.triangles[k][0], turned.triangles[k][1]);
    EXPECT_FALSE(Pair(before, turned, 1.0).is_known());
  }
}

}  // namespace
}  // namespace palpate::simplify

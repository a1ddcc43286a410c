#include "core/simplify/surface/surface_smoothing.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/judge/surface/feature_distance.h"
#include "tests/support/rough_skin.h"

namespace palpate::simplify {
namespace {

using namespace palpate::testing_support;  // NOLINT(google-build-using-namespace)

constexpr int kCells = kRoughCells;
using Skin = GuardedSkin;

TEST(SurfaceSmoothing, EachSweepRaisesTheSumOfGainsWithinTheBound) {
  for (const double bound : {0.02, 0.1, 0.5}) {
    Skin skin(make_rough_block(3), bound);
    double before = skin.worth();
    const double at_first = before;
    for (int sweep = 0; sweep < 3; ++sweep) {
      const std::uint64_t moves = skin.report.moves;
      smooth_boundary(skin.mesh, skin.boundary, skin.scores, total_volume(skin.input), skin.report);
      const double now = skin.worth();
      if (skin.report.moves > moves) {
        EXPECT_GT(now, before) << bound << ", sweep " << sweep;
      }
      before = now;
    }
    EXPECT_GT(before, at_first) << bound;
    skin.judged(bound);
  }
}

TEST(SurfaceSmoothing, DoesNotCrumpleTheSkin) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    Skin skin(make_rough_block(seed), 1.0);  // a bound that would permit anything
    for (int sweep = 0; sweep < 4; ++sweep)
      smooth_boundary(skin.mesh, skin.boundary, skin.scores, total_volume(skin.input), skin.report);
    const double before = judge::total_bend(judge::build_boundary(skin.input));
    EXPECT_LT(judge::total_bend(judge::build_boundary(skin.judged(1.0))), 1.02 * before) << "seed " << seed;
  }
}

TEST(SurfaceSmoothing, ReachesMoreThanMendingTheWorst) {
  const double bound = 0.3;
  Skin smoothed(make_rough_block(3), bound);
  Skin mended(make_rough_block(3), bound);
  for (int sweep = 0; sweep < 3; ++sweep) {
    smooth_boundary(smoothed.mesh, smoothed.boundary, smoothed.scores, total_volume(smoothed.input),
                    smoothed.report);
    mend_boundary(mended.mesh, mended.boundary, mended.scores, mended.report);
  }
  EXPECT_GT(mended.report.moves, 0U);
  EXPECT_GT(smoothed.worth(), mended.worth());
}

TEST(SurfaceSmoothing, TheVolumeStaysWithinAThousandthAndAMove) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    Skin skin(make_rough_block(seed), 0.5);
    const double volume = total_volume(skin.input);
    EXPECT_NEAR(skin.volume(), volume, 1e-9 * volume);
    for (int sweep = 0; sweep < 4; ++sweep)
      smooth_boundary(skin.mesh, skin.boundary, skin.scores, volume, skin.report);
    const TetMesh output = skin.judged(0.5);
    EXPECT_NEAR(skin.volume(), total_volume(output), 1e-9 * volume);
    EXPECT_LT(std::fabs(total_volume(output) / volume - 1.0), 0.002) << "seed " << seed;
  }
}

TEST(SurfaceSmoothing, WhatIsMissingOfTheVolumeIsOnlyMadeUpFor) {
  for (const double wanted : {1.05, 0.95}) {
    Skin skin(make_rough_block(2), 0.5);
    const double before = total_volume(skin.input);
    smooth_boundary(skin.mesh, skin.boundary, skin.scores, wanted * before, skin.report);
    EXPECT_GT(skin.report.moves, 20U);
    // Each single move leads there or, within the tangent plane, changes nothing.
    EXPECT_GT((skin.volume() - before) * (wanted - 1.0), 0.0) << wanted;
  }
}

TEST(SurfaceSmoothing, WithoutABoundAFlatSkinMovesWithinItselfAndARoundOneNotAtAll) {
  Skin round(make_rough_block(5), 0.0);
  smooth_boundary(round.mesh, round.boundary, round.scores, total_volume(round.input), round.report);
  EXPECT_EQ(round.report.moves, 0U);
  TetMesh block = make_kuhn_block(kCells, kCells, kCells);
  for (Vec3& p : block.points) {  // the middles of its faces, moved within these
    if (p.z == kCells && p.x > 0.5 && p.x < kCells - 0.5 && p.y > 0.5 && p.y < kCells - 0.5)
      p = p + Vec3{0.25, -0.2, 0.0};
  }
  const Vec3 axis = (1.0 / std::sqrt(14.0)) * Vec3{1.0, 2.0, 3.0};
  for (const double turn : {0.0, 0.7}) {  // flat to the bit, and flat but for rounding
    TetMesh turned = block;
    for (Vec3& p : turned.points)
      p = std::cos(turn) * p + std::sin(turn) * cross(axis, p) + (1.0 - std::cos(turn)) * dot(axis, p) * axis;
    Skin flat(turned, 1e-9);
    smooth_boundary(flat.mesh, flat.boundary, flat.scores, total_volume(turned), flat.report);
    EXPECT_GT(flat.report.moves, 5U) << turn;
    EXPECT_NEAR(flat.volume(), total_volume(turned), 1e-7) << turn;
    flat.judged(1e-9);
  }
}

TEST(SurfaceSmoothing, VerticesOnSharpEdgesStay) {
  Skin skin(make_kuhn_block(kCells, kCells, kCells), 0.4, 40.0);
  const std::vector<Vec3> before = skin.mesh.points;
  for (int sweep = 0; sweep < 2; ++sweep)
    smooth_boundary(skin.mesh, skin.boundary, skin.scores, total_volume(skin.input), skin.report);
  std::size_t held = 0;
  for (Index v = 0; v < before.size(); ++v) {
    if (skin.boundary.lines().rank(v) == FeatureRank::kNone) continue;
    ++held;
    EXPECT_EQ(skin.mesh.points[v], before[v]);
  }
  EXPECT_EQ(held, 12U * (kCells - 1) + 8U);
}

}  // namespace
}  // namespace palpate::simplify

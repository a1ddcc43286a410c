#include "core/simplify/surface/surface_flip.h"

#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "core/judge/surface/feature_distance.h"
#include "tests/support/rough_skin.h"

namespace palpate::simplify {
namespace {

using namespace palpate::testing_support;  // NOLINT(google-build-using-namespace)

constexpr double kAnyScore = 1e300;
constexpr double kBound = 0.3;

/// Each edge of the skin, once.
std::vector<std::array<Index, 2>> edges_of(const GuardedBoundary& boundary) {
  std::vector<std::array<Index, 2>> edges;
  boundary.for_each_edge([&](Index a, Index b) { edges.push_back({a, b}); });
  return edges;
}

TEST(SurfaceFlip, ForTheSumEachFlipRaisesIt) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    GuardedSkin skin(make_rough_block(seed), kBound);
    BoundaryFlipper flipper(skin.mesh, skin.boundary, skin.scores, FlipAim::kSum);
    double before = skin.worth();
    std::size_t flips = 0;
    for (const auto& [a, b] : edges_of(skin.boundary)) {
      if (!flipper.try_flip(a, b, kAnyScore)) continue;
      const double now = skin.worth();
      EXPECT_GT(now, before) << "seed " << seed << ", edge " << a << " " << b;
      before = now;
      ++flips;
    }
    EXPECT_GT(flips, 20U) << "seed " << seed;
    skin.judged(kBound);
  }
}

TEST(SurfaceFlip, ForTheSumMoreIsReachedThanForTheWorst) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    GuardedSkin by_sum(make_rough_block(seed), kBound);
    GuardedSkin by_worst(make_rough_block(seed), kBound);
    BoundaryFlipper summed(by_sum.mesh, by_sum.boundary, by_sum.scores, FlipAim::kSum);
    BoundaryFlipper worst(by_worst.mesh, by_worst.boundary, by_worst.scores, FlipAim::kWorst);
    for (int pass = 0; pass < 3; ++pass) {
      summed.pass(kAnyScore);
      worst.pass(kAnyScore);
    }
    EXPECT_GT(by_sum.worth(), by_worst.worth()) << "seed " << seed;
  }
}

TEST(SurfaceFlip, NoFlipLeavesATetBelowAShareOfTheWorst) {
  GuardedSkin skin(make_rough_block(4), kBound);
  BoundaryFlipper flipper(skin.mesh, skin.boundary, skin.scores, FlipAim::kSum);
  for (const auto& [a, b] : edges_of(skin.boundary)) {
    const double before = skin.worst();
    if (flipper.try_flip(a, b, kAnyScore)) {
      EXPECT_GE(skin.worst(), 0.49 * before);
    }
  }
}

/// Edges of a skin whose faces' normals differ by more than a right angle.
std::size_t count_folds(const TetMesh& mesh) {
  return judge::list_sharp_edges(judge::build_boundary(mesh), 90.0).size();
}

/// Flips a shaken plate once over. Returns how many edges were flipped; `folds` is how many folds it has
/// more.
std::uint64_t flip_plate(std::uint64_t seed, FlipAim aim, bool may_fold, std::int64_t& folds) {
  TetMesh plate = make_kuhn_block(8, 8, 1);
  SplitMix64 random(seed);
  for (Vec3& p : plate.points)
    p = p + 0.3 * Vec3{random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5};
  GuardedSkin skin(plate, 1.0);  // as thick as the plate
  BoundaryFlipper flipper(skin.mesh, skin.boundary, skin.scores, aim);
  flipper.set_may_fold(may_fold);
  const std::uint64_t flips = flipper.pass(kAnyScore);
  folds = static_cast<std::int64_t>(count_folds(skin.judged(1.0))) -
          static_cast<std::int64_t>(count_folds(plate));
  return flips;
}

TEST(SurfaceFlip, NoneFoldsTheSkinWhereNoneMay) {
  for (const FlipAim aim : {FlipAim::kSum, FlipAim::kWorst}) {
    std::uint64_t flips = 0;
    std::int64_t most = 0;
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
      std::int64_t folds = 0;
      flips += flip_plate(seed, aim, false, folds);
      EXPECT_LE(folds, 0) << "seed " << seed;
      flip_plate(seed, aim, true, folds);
      most = std::max(most, folds);
    }
    EXPECT_GT(flips, 50U);
    EXPECT_GT(most, 0);
  }
}

TEST(SurfaceFlip, StaysWithinTheRangeOfCounts) {
  for (const FlipAim aim : {FlipAim::kSum, FlipAim::kWorst}) {
    GuardedSkin skin(make_rough_block(2), kBound);
    BoundaryFlipper flipper(skin.mesh, skin.boundary, skin.scores, aim);
    const std::uint64_t tets = skin.mesh.alive;
    flipper.set_range(tets, tets);
    EXPECT_GT(flipper.pass(kAnyScore), 0U);
    EXPECT_EQ(skin.mesh.alive, tets);
    skin.judged(kBound);
  }
}

TEST(SurfaceFlip, PassesEnd) {
  GuardedSkin skin(make_rough_block(1), kBound);
  BoundaryFlipper flipper(skin.mesh, skin.boundary, skin.scores, FlipAim::kSum);
  int passes = 0;
  while (flipper.pass(kAnyScore) > 0) ASSERT_LT(++passes, 30);
}

}  // namespace
}  // namespace palpate::simplify

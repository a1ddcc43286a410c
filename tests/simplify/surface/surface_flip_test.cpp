#include "core/simplify/surface/surface_flip.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <utility>
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

struct FlippedPlate {
  std::uint64_t flips = 0;
  std::int64_t more_folds = 0;
};

/// Flips a shaken plate once over, by what `aim` may do itself unless something is said of folds.
FlippedPlate flip_plate(std::uint64_t seed, FlipAim aim, std::optional<bool> may_fold) {
  TetMesh plate = make_kuhn_block(8, 8, 1);
  SplitMix64 random(seed);
  for (Vec3& p : plate.points)
    p = p + 0.3 * Vec3{random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5};
  GuardedSkin skin(plate, 1.0);  // as thick as the plate
  BoundaryFlipper flipper(skin.mesh, skin.boundary, skin.scores, aim);
  if (may_fold) flipper.set_may_fold(*may_fold);
  const std::uint64_t flips = flipper.pass(kAnyScore);
  return {flips, static_cast<std::int64_t>(count_folds(skin.judged(1.0))) -
                     static_cast<std::int64_t>(count_folds(plate))};
}

/// Flips plates that may not be folded, which none is, and that may, of which one is.
void expect_folds_only_where_some_may(FlipAim aim, std::optional<bool> may_not, std::optional<bool> may) {
  std::uint64_t flips = 0;
  std::int64_t most = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const FlippedPlate flat = flip_plate(seed, aim, may_not);
    EXPECT_LE(flat.more_folds, 0) << "seed " << seed;
    flips += flat.flips;
    most = std::max(most, flip_plate(seed, aim, may).more_folds);
  }
  EXPECT_GT(flips, 50U);
  EXPECT_GT(most, 0);
}

TEST(SurfaceFlip, ForTheSumNoneFoldsTheSkin) {
  expect_folds_only_where_some_may(FlipAim::kSum, std::nullopt, true);
}

TEST(SurfaceFlip, ForTheWorstNoneFoldsTheSkinWhereNoneMay) {
  expect_folds_only_where_some_may(FlipAim::kWorst, false, std::nullopt);
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

/// A pass that forgets: each edge is tried from both of its faces.
std::uint64_t flip_edges_of_faces(BoundaryFlipper& flipper, const GuardedBoundary& boundary,
                                  double threshold) {
  std::uint64_t flips = 0;
  for (Index f = 0; f < boundary.slots(); ++f) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Triangle& t = boundary.face(f);
      const auto [a, b] = std::minmax(t[k], t[(k + 1) % 3]);
      if (flipper.try_flip(a, b, threshold)) ++flips;
    }
  }
  return flips;
}

TEST(SurfaceFlip, APassPassesOverNoEdgeThatWouldBeFlipped) {
  for (const FlipAim aim : {FlipAim::kSum, FlipAim::kWorst}) {
    for (std::uint64_t seed = 1; seed <= 60; ++seed) {
      GuardedSkin skin(make_rough_block(seed), kBound);
      GuardedSkin other(make_rough_block(seed), kBound);
      BoundaryFlipper flipper(skin.mesh, skin.boundary, skin.scores, aim);
      BoundaryFlipper forgetful(other.mesh, other.boundary, other.scores, aim);
      for (const double threshold : {kAnyScore, 0.3, kAnyScore}) {
        EXPECT_EQ(flipper.pass(threshold), flip_edges_of_faces(forgetful, other.boundary, threshold));
      }
      EXPECT_EQ(extract_mesh(std::move(skin.mesh)).tets, extract_mesh(std::move(other.mesh)).tets)
          << "seed " << seed;
    }
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

#include <gtest/gtest.h>

#include "core/judge/mesh/judge.h"
#include "core/simplify/surface/surface.h"
#include "tests/support/rough_skin.h"

namespace palpate::simplify {
namespace {

using namespace palpate::testing_support;  // NOLINT(google-build-using-namespace)

constexpr double kBoundOfEffort = 0.5;

/// Sums over some bodies.
struct Sums {
  std::uint64_t moves_and_flips = 0;
  double quality = 0.0;
  std::uint64_t cures_and_splits = 0;  ///< collapses and splits in the skin
};

Sums simplify_some(int effort, Objective objective, bool sparing) {
  Sums sums;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const TetMesh input = make_rough_block(seed);
    SurfaceOptions options;
    options.stop.ratio = 0.7;
    options.max_surface_error = kBoundOfEffort;
    options.effort = effort;
    options.objective = objective;
    options.sparing = sparing;
    TetMesh mesh = input;
    const SurfaceRunReport report = simplify_surface(mesh, options);
    EXPECT_EQ(report.stop, "ratio");
    EXPECT_TRUE(judge::check_validity(mesh).is_valid());
    const SurfaceMesh skin = judge::build_boundary(mesh);
    EXPECT_LE(judge::measure_surface_distance(skin, judge::build_boundary(input)).upper(), kBoundOfEffort);
    EXPECT_GT(report.surface.moves, 0U) << "seed " << seed;  // once at least
    sums.moves_and_flips += report.surface.moves + report.surface.flips;
    sums.cures_and_splits += report.surface.collapses + report.surface.splits;
    sums.quality += judge::measure_quality(mesh).mean_quality;
  }
  return sums;
}

TEST(SurfaceEffort, WithoutAnyTheSkinIsEvenedOutOnceAndNotOnTheWay) {
  for (const Objective objective : {Objective::kShape, Objective::kQuality}) {
    for (const bool sparing : {true, false}) {
      const Sums quick = simplify_some(0, objective, sparing);
      const Sums usual = simplify_some(1, objective, sparing);
      EXPECT_LT(quick.moves_and_flips, 0.7 * static_cast<double>(usual.moves_and_flips));
      EXPECT_LT(quick.quality, usual.quality);
    }
  }
}

TEST(SurfaceEffort, TheMoreTheOftenerLengthsAreEvenedOut) {
  std::uint64_t before = 0;
  for (const int effort : {1, 3, 5}) {
    const Sums sums = simplify_some(effort, Objective::kShape, false);
    EXPECT_GT(sums.cures_and_splits, before) << "effort " << effort;
    before = sums.cures_and_splits;
  }
}

}  // namespace
}  // namespace palpate::simplify

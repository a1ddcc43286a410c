#include "core/simplify/surface/surface_split.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <vector>

#include "core/mesh/geometry.h"
#include "core/simplify/surface/surface_flip.h"
#include "core/simplify/surface/surface_smoothing.h"
#include "tests/support/refined_checks.h"
#include "tests/support/rough_skin.h"

namespace palpate::simplify {
namespace {

using namespace palpate::testing_support;  // NOLINT(google-build-using-namespace)

constexpr double kSplitBound = 0.3;

std::uint64_t split(GuardedSkin& skin, const SurfaceSplitOptions& options) {
  return split_boundary_edges(skin.mesh, skin.boundary, skin.scores, options);
}

double longest_edge(const GuardedSkin& skin) {
  double longest = 0.0;
  skin.boundary.for_each_edge([&](Index a, Index b) {
    longest = std::max(longest, length(skin.mesh.points[b] - skin.mesh.points[a]));
  });
  return longest;
}

TEST(SurfaceSplit, LeavesTheSkinWhereItIsAndNoLongEdge) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    GuardedSkin skin(make_rough_block(seed), 0.0);
    const std::size_t faces = skin.boundary.size();
    const double volume = skin.volume();
    SurfaceSplitOptions options;
    options.shortest = 1.3;
    ASSERT_GT(longest_edge(skin), options.shortest);
    const std::uint64_t splits = split(skin, options);
    EXPECT_GT(splits, 20U) << "seed " << seed;
    EXPECT_EQ(skin.boundary.size(), faces + 2 * splits);
    EXPECT_LT(longest_edge(skin), 1.6);
    EXPECT_NEAR(skin.volume(), volume, 1e-12 * volume);
    expect_consistent(skin.mesh);
    skin.judged(0.0);
  }
}

TEST(SurfaceSplit, TheLongestGoesFirstUpToTheTargets) {
  GuardedSkin one(make_rough_block(1), kSplitBound);
  const double before = longest_edge(one);
  SurfaceSplitOptions options;
  options.face_target = one.boundary.size() + 1;
  EXPECT_EQ(split(one, options), 1U);
  EXPECT_LT(longest_edge(one), before);

  GuardedSkin by_tets(make_rough_block(1), kSplitBound);
  options = {};
  options.tet_target = by_tets.mesh.alive + 10;
  options.most_tets = by_tets.mesh.alive + 11;
  EXPECT_GT(split(by_tets, options), 1U);
  EXPECT_GE(by_tets.mesh.alive, options.tet_target);
  EXPECT_LE(by_tets.mesh.alive, options.most_tets);

  GuardedSkin none(make_rough_block(1), kSplitBound);
  options = {};
  options.least_score = 1.0;
  const std::size_t vertices = copy_of(none.mesh).points.size();
  EXPECT_EQ(split(none, options), 0U);
  EXPECT_EQ(copy_of(none.mesh).points.size(), vertices);
  expect_consistent(none.mesh);
}

TEST(SurfaceSplit, WithWantedSizesTheLongestOverThemGoesFirst) {
  const TetMesh block = make_rough_block(1);
  const BoundingBox box = bounding_box(block.points);
  // Ten times as long at the one end as at the other: no edge is ten times as long as another.
  const auto wanted_at = [&](double x) { return 0.1 + 0.9 * (x - box.low.x) / (box.high.x - box.low.x); };
  std::vector<double> sizes;
  for (const Vec3& p : block.points) sizes.push_back(wanted_at(p.x));
  SizingOptions sizing;
  sizing.sizes = make_size_grid(block, sizes);
  GuardedSkin skin(block, kSplitBound, 0.0, sizing);
  std::array<Index, 2> longest{};
  std::array<Index, 2> farthest_out{};
  double greatest = 0.0;
  double most = 0.0;
  skin.boundary.for_each_edge([&](Index a, Index b) {
    const double size = length(skin.mesh.points[b] - skin.mesh.points[a]);
    const double over = size / skin.field.relative_size(0.5 * (skin.mesh.points[a] + skin.mesh.points[b]));
    if (size > greatest) longest = {a, b};
    if (over > most) farthest_out = {a, b};
    greatest = std::max(greatest, size);
    most = std::max(most, over);
  });
  ASSERT_NE(longest, farthest_out);
  SurfaceSplitOptions options;
  options.face_target = skin.boundary.size() + 1;
  EXPECT_EQ(split(skin, options), 1U);
  bool has_longest = false;
  skin.boundary.for_each_edge([&](Index a, Index b) {
    has_longest = has_longest || std::array{a, b} == longest;
    EXPECT_NE((std::array{a, b}), farthest_out);
  });
  EXPECT_TRUE(has_longest);
}

TEST(SurfaceSplit, WhatFollowsIsHeldToTheBound) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    SCOPED_TRACE(seed);
    GuardedSkin skin(make_rough_block(seed), kSplitBound);
    SurfaceSplitOptions options;
    options.shortest = 1.2;
    SurfaceCollapseOptions collapses;
    collapses.least_score = 0.01;
    for (int round = 0; round < 3; ++round) {
      EXPECT_GT(split(skin, options), 0U);
      BoundaryFlipper flipper(skin.mesh, skin.boundary, skin.scores, FlipAim::kSum);
      flipper.pass(1e300);
      smooth_boundary(skin.mesh, skin.boundary, skin.scores, skin.volume(), skin.report);
      collapses.face_target = skin.boundary.size() * 4 / 5;
      collapse_boundary_edges(skin.mesh, skin.boundary, skin.scores, collapses, skin.report);
      expect_consistent(skin.mesh);
      skin.judged(kSplitBound);
    }
    EXPECT_GT(skin.report.collapses, 50U);
    EXPECT_GT(skin.report.moves, 20U);
  }
}

TEST(SurfaceSplit, FeatureEdgesAndKeptTetsStay) {
  GuardedSkin skin(make_kuhn_block(3, 3, 3), 0.0, 60.0);
  const std::size_t lines = skin.boundary.lines().size();
  ASSERT_EQ(lines, 36U);
  EXPECT_EQ(split(skin, {}), 6U * 21U);  // of 162 edges
  EXPECT_EQ(skin.boundary.lines().size(), lines);

  GuardedSkin kept(make_kuhn_block(3, 3, 3), 0.0);
  kept.mesh.kept_tets.assign(kept.mesh.tets.size(), 1);
  EXPECT_EQ(split(kept, {}), 0U);
}

}  // namespace
}  // namespace palpate::simplify

#include "core/simplify/tet_operations/flips.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <set>

#include "core/base/random.h"
#include "core/mesh/geometry.h"
#include "core/mesh/shapes/shapes.h"
#include "core/simplify/quality/quality.h"
#include "tests/support/refined_checks.h"
#include "tests/support/small_meshes.h"

namespace palpate::simplify {
namespace {

using namespace palpate::testing_support;  // NOLINT(google-build-using-namespace)

WorkingMesh build(const TetMesh& mesh, const SizingField& field = {}) {
  TetMesh copy = mesh;
  return build_working_mesh(std::move(copy), field);
}

double mean_volume(const TetMesh& mesh) {
  return total_volume(mesh) / static_cast<double>(mesh.tets.size());
}

/// The best filling by trying every triangulation of the polygon i .. j.
double best_by_brute_force(const RingValues& value, std::size_t i, std::size_t j) {
  if (j < i + 2) return 0.0;
  double best = kForbidden;
  for (std::size_t k = i + 1; k < j; ++k) {
    const double left = best_by_brute_force(value, i, k);
    const double right = best_by_brute_force(value, k, j);
    if (left == kForbidden || right == kForbidden || value[i][k][j] == kForbidden) continue;
    best = std::max(best, left + right + value[i][k][j]);
  }
  return best;
}

/// The triangles that may be, a bit each.
std::uint64_t allowed_in(const RingValues& value, std::size_t size) {
  const RingTriangles& triangles = ring_triangles(size);
  std::uint64_t allowed = 0;
  for (std::size_t t = 0; t < triangles.size; ++t) {
    const auto at = [&](std::size_t c) { return static_cast<std::size_t>(triangles.corner[c][t]); };
    if (value[at(0)][at(1)][at(2)] != kForbidden) allowed |= std::uint64_t{1} << t;
  }
  return allowed;
}

TEST(RingFilling, SignsTellWhetherThereIsOne) {
  SplitMix64 random(12);
  for (std::size_t n = 3; n <= kLargestRing; ++n) {
    std::size_t possible = 0;
    for (int trial = 0; trial < 400; ++trial) {
      RingValues value{};
      const double share = random.uniform();
      for (auto& plane : value) {
        for (auto& row : plane) {
          for (double& x : row) x = random.uniform() < share ? kForbidden : 0.0;
        }
      }
      const bool is_possible = best_by_brute_force(value, 0, n - 1) != kForbidden;
      ASSERT_EQ(can_fill_ring(allowed_in(value, n), n), is_possible) << n << " trial " << trial;
      possible += is_possible ? 1U : 0U;
    }
    EXPECT_GT(possible, 40U) << n;
    EXPECT_LT(possible, 360U) << n;
  }
}

TEST(RingFilling, SameAsAllTriangulationsByBruteForce) {
  SplitMix64 random(11);
  std::vector<RingTriangle> triangles;
  for (std::size_t n = 3; n <= kLargestRing; ++n) {
    for (int trial = 0; trial < 300; ++trial) {
      RingValues value{};
      for (auto& plane : value) {
        for (auto& row : plane) {
          for (double& x : row) x = random.uniform() < 0.25 ? kForbidden : random.uniform() - 0.5;
        }
      }
      const double best = best_ring_filling(value, n, triangles);
      ASSERT_DOUBLE_EQ(best, best_by_brute_force(value, 0, n - 1)) << n << " trial " << trial;
      if (best == kForbidden) {
        EXPECT_TRUE(triangles.empty());
        continue;
      }
      ASSERT_EQ(triangles.size(), n - 2);
      double sum = 0.0;
      std::multiset<std::array<std::size_t, 2>> sides;  // each diagonal twice, each side of the ring once
      for (const auto& [i, k, j] : triangles) {
        sum += value[i][k][j];
        for (const auto& side : {std::array{i, k}, std::array{k, j}, std::array{i, j}}) sides.insert(side);
      }
      EXPECT_NEAR(sum, best, 1e-12);
      for (const auto& side : sides) {
        const bool on_ring = side[1] == side[0] + 1 || (side[0] == 0 && side[1] == n - 1);
        EXPECT_EQ(sides.count(side), on_ring ? 1U : 2U);
      }
    }
  }
}

TEST(EdgeRing, IsClosedAndPositive) {
  const WorkingMesh mesh = build(build_kuhn_cube(4, 0.3, 3));
  EdgeRing ring;
  std::size_t found = 0;
  for (Index t = 0; t < mesh.tets.size(); ++t) {
    for (const auto& e : kTetEdges) {
      const Index a = mesh.tets[t][static_cast<std::size_t>(e[0])];
      const Index b = mesh.tets[t][static_cast<std::size_t>(e[1])];
      std::vector<Index> star;
      collect_edge_star(mesh, a, b, star);
      if (!find_edge_ring(mesh, a, b, ring)) {
        EXPECT_TRUE(star.size() > kLargestRing || (mesh.is_on_boundary(a) && mesh.is_on_boundary(b)));
        continue;
      }
      ++found;
      ASSERT_EQ(ring.size, star.size());
      for (std::size_t i = 0; i < ring.size; ++i) {
        std::multiset<Index> expected{a, b, ring.ring[i], ring.ring[(i + 1) % ring.size]};
        const Tet& tet = mesh.tets[ring.tets[i]];
        EXPECT_EQ(std::multiset<Index>(tet.begin(), tet.end()), expected);
        EXPECT_GT(signed_volume(mesh.points[a], mesh.points[b], mesh.points[ring.ring[i]],
                                mesh.points[ring.ring[(i + 1) % ring.size]]),
                  0.0);
      }
    }
  }
  EXPECT_GT(found, 0U);
}

FlipRule anything() {
  FlipRule rule;
  rule.least_growth = -1e299;
  rule.least_of_worst = 0.0;
  return rule;
}

TEST(Flipper, ValidAfterEachOfManyFlipsAndEachCanBeUndone) {
  for (const std::uint64_t seed : {5U, 6U}) {
    SCOPED_TRACE(seed);
    const TetMesh input = build_kuhn_cube(5, 0.4, seed);
    WorkingMesh mesh = build(input);
    const SizingField no_field;
    const ScoreRule scores(scale_of_ideal_volume(mean_volume(input)), no_field);
    Flipper flipper(mesh, scores, anything());
    SplitMix64 random(seed);
    std::array<std::size_t, 3> made{};
    for (int i = 0; i < 1500; ++i) {
      const auto t = static_cast<Index>(random.below(mesh.tets.size()));
      if (!mesh.is_alive(t)) continue;
      const TetMesh before = copy_of(mesh);
      const Tet tet = mesh.tets[t];
      const auto& e = kTetEdges[random.below(6)];
      const Index a = tet[static_cast<std::size_t>(e[0])];
      const Index b = tet[static_cast<std::size_t>(e[1])];
      const std::uint64_t kind = random.below(3);
      const bool done = kind == 0   ? flipper.try_remove_edge(a, b)
                        : kind == 1 ? flipper.try_remove_face(t, random.below(4))
                                    : flipper.split_edge(a, b) != kNoIndex;
      if (!done) continue;
      ++made[kind];
      expect_valid_with_boundary_of(copy_of(mesh), input);
      if (random.below(2) == 0) continue;
      flipper.undo();
      TetMesh after = copy_of(mesh);
      const auto sorted = [](TetMesh m) {
        for (Tet& x : m.tets) std::sort(x.begin(), x.end());
        std::sort(m.tets.begin(), m.tets.end());
        return m;
      };
      ASSERT_EQ(sorted(after), sorted(before));
    }
    for (const std::size_t count : made) EXPECT_GT(count, 20U);
    expect_consistent(mesh);
  }
}

TEST(Flipper, RemovingTheFaceAndThenTheEdgeGivesTheTwoTetsBack) {
  TetMesh input;
  input.points = {{1, 0, 0}, {-0.5, 0.8, 0}, {-0.5, -0.8, 0}, {0, 0, 1}, {0, 0, -1.2}};
  input.tets = {{0, 1, 2, 3}, {0, 2, 1, 4}};
  WorkingMesh mesh = build(input);
  const SizingField no_field;
  const ScoreRule scores(scale_of_ideal_volume(mean_volume(input)), no_field);
  Flipper flipper(mesh, scores, anything());
  bool flipped = false;
  for (std::size_t corner = 0; corner < 4 && !flipped; ++corner) {
    flipped = flipper.try_remove_face(0, corner);
  }
  ASSERT_TRUE(flipped);
  EXPECT_EQ(mesh.alive, 3U);
  EdgeRing ring;
  ASSERT_TRUE(find_edge_ring(mesh, mesh.tets[flipper.added()[0]][0], mesh.tets[flipper.added()[0]][3], ring));
  EXPECT_EQ(ring.size, 3U);
  ASSERT_TRUE(flipper.try_remove_edge(ring.a, ring.b));
  EXPECT_EQ(mesh.alive, 2U);
  expect_valid_with_boundary_of(copy_of(mesh), input);
}

TEST(Flipper, EveryFlipByTheRuleRaisesTheSumOfGains) {
  const TetMesh input = make_sliver_cube(5, 9);
  WorkingMesh mesh = build(input);
  const SizingField no_field;
  const ScoreRule scores(scale_of_ideal_volume(mean_volume(input)), no_field);
  const FlipRule rule;
  Flipper flipper(mesh, scores, rule);
  const auto total = [&] {
    double sum = 0.0;
    for (Index t = 0; t < mesh.tets.size(); ++t) {
      if (!mesh.is_alive(t)) continue;
      sum += gain_of_score(scores.far(), flipper.known_score(t)) -
             gain_of_score(scores.far(), scores.far().usual_score);
    }
    return sum;
  };
  std::size_t flips = 0;
  for (Index t = 0; t < mesh.tets.size() && flips < 60; ++t) {
    if (!mesh.is_alive(t)) continue;
    const double before = total();
    if (!flipper.try_edges_of(t)) continue;
    ++flips;
    // Scores are single precision: about 1e-6 of each of the up to 10 gains, each at most 1 / 0.1.
    EXPECT_NEAR(total() - before, flipper.growth(), 1e-3);
    EXPECT_GT(flipper.growth(), rule.least_growth);
  }
  EXPECT_GT(flips, 20U);
}

/// Tets around the largest ring that gave way where rings of so many at most may.
std::size_t largest_ring_removed(std::size_t most) {
  const TetMesh input = build_kuhn_cube(5, 0.4, 5);
  const SizingField no_field;
  const ScoreRule scores(scale_of_ideal_volume(mean_volume(input)), no_field);
  WorkingMesh mesh = build(input);
  FlipRule rule = anything();
  rule.largest_ring = most;
  Flipper flipper(mesh, scores, rule);
  std::size_t largest = 0;
  for (Index t = 0; t < input.tets.size(); ++t) {
    if (!mesh.is_alive(t)) continue;
    const Tet tet = mesh.tets[t];
    if (flipper.try_edges_of(t) || flipper.try_remove_edge(tet[0], tet[1]))
      largest = std::max(largest, flipper.removed().size());
  }
  return largest;
}

TEST(Flipper, LeavesLargerRingsThanTheRulePermits) {
  EXPECT_EQ(largest_ring_removed(4), 4U);
  EXPECT_EQ(largest_ring_removed(5), 5U);
  EXPECT_GT(largest_ring_removed(kLargestRing), 5U);
}

TEST(Flipper, KeepsToTheWindowOfCountsAndToKeptTets) {
  const TetMesh input = make_sliver_cube(5, 3);
  SizingOptions options;
  options.keep.push_back({.kind = KeptRegion::Kind::kSphere, .center = {0.5, 0.5, 0.5}, .radius = 0.25});
  const SizingField field(options, input);
  WorkingMesh mesh = build(input, field);
  const ScoreRule scores(scale_of_ideal_volume(mean_volume(input)), field);
  FlipRule rule = anything();
  rule.fewest_tets = input.tets.size() - 3;
  rule.most_tets = input.tets.size() + 2;
  Flipper flipper(mesh, scores, rule);
  std::vector<Tet> kept;
  for (Index t = 0; t < mesh.tets.size(); ++t) {
    if (mesh.is_kept(t)) kept.push_back(mesh.tets[t]);
  }
  ASSERT_FALSE(kept.empty());
  SplitMix64 random(1);
  for (int i = 0; i < 4000; ++i) {
    const auto t = static_cast<Index>(random.below(mesh.tets.size()));
    if (!mesh.is_alive(t)) continue;
    const Tet tet = mesh.tets[t];
    if (random.below(2) == 0) {
      flipper.try_remove_face(t, random.below(4));
    } else {
      flipper.try_remove_edge(tet[0], tet[1 + random.below(3)]);
    }
    ASSERT_GE(mesh.alive, rule.fewest_tets);
    ASSERT_LE(mesh.alive, rule.most_tets);
  }
  std::vector<Tet> still;
  for (Index t = 0; t < mesh.tets.size(); ++t) {
    if (mesh.is_kept(t)) still.push_back(mesh.tets[t]);
  }
  EXPECT_EQ(still, kept);
}

}  // namespace
}  // namespace palpate::simplify

// Repairs where many tets are bad: none makes the worst worse, and what keeps failing is given up.
#include "core/simplify/refined/repair.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/mesh/geometry.h"
#include "core/simplify/tet_operations/quality_floor.h"
#include "tests/support/refined_checks.h"

namespace palpate::simplify {
namespace {

using namespace palpate::testing_support;  // NOLINT(google-build-using-namespace)

constexpr double kThreshold = 0.13;

struct Figures {
  double least = 1.0;
  double share_bad = 0.0;
};

Figures figures_of(const WorkingMesh& mesh, Flipper& flipper) {
  Figures found;
  for (Index t = 0; t < mesh.tets.size(); ++t) {
    if (!mesh.is_alive(t)) continue;
    const double score = flipper.known_score(t);
    found.least = std::min(found.least, score);
    if (score < kThreshold) found.share_bad += 1.0 / static_cast<double>(mesh.alive);
  }
  return found;
}

TEST(Repairer, WhereManyAreBadNoRoundMakesTheWorstWorse) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE(seed);
    const TetMesh input = make_sliver_cube(7, seed);
    const SizingField no_field;
    TetMesh copy = input;
    WorkingMesh mesh = build_working_mesh(std::move(copy), no_field);
    const ScoreRule scores(
        scale_of_ideal_volume(total_volume(input) / static_cast<double>(input.tets.size())), no_field);
    Flipper flipper(mesh, scores, {});
    Figures before = figures_of(mesh, flipper);
    ASSERT_GT(before.share_bad, 0.1);  // the manner that is looked at here
    const double share_at_first = before.share_bad;
    Repairer repairer(mesh, scores, {}, {});
    repairer.set_manner(kThreshold);
    for (int round = 0; round < 4; ++round) {
      repairer.round(kThreshold, 0.05, 2);
      const Figures after = figures_of(mesh, flipper);
      EXPECT_GE(after.least, before.least);
      before = after;
    }
    EXPECT_LT(before.share_bad, share_at_first);
    expect_consistent(mesh);
    expect_valid_with_boundary_of(copy_of(mesh), input);
  }
}

TEST(RepairSuccess, WhatHelpsTooSeldomIsGivenUp) {
  RepairSuccess never;
  int tries = 0;
  while (never.is_worth_it()) {
    EXPECT_FALSE(never.note(false));
    ++tries;
  }
  RepairSuccess sometimes;
  for (int i = 0; i < 100 * tries; ++i) {
    ASSERT_TRUE(sometimes.is_worth_it()) << i;
    sometimes.note(i % (tries / 2) == 0);
  }
}

/// Rounds on meshes with few bad tets, with the whole of the repairs' means. Returns by how much the worst
/// score of the mesh fell in the worst round, over what it was before.
double worst_fall(bool never_worse) {
  double fall = 0.0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const SizingField no_field;
    WorkingMesh mesh = build_working_mesh(make_sliver_cube(7, seed), no_field);
    const double ideal = 1.0 / static_cast<double>(mesh.alive);
    const ScoreRule scores(scale_of_ideal_volume(ideal), no_field);
    Flipper flipper(mesh, scores, {});
    RepairTools tools;
    tools.never_worse = never_worse;
    Repairer repairer(mesh, scores, {}, tools);  // without set_manner: as where few are bad
    for (int round = 0; round < 6; ++round) {
      const double before = figures_of(mesh, flipper).least;
      // With compound moves, shifted flips and splits in the odd rounds.
      repairer.round(kThreshold, round % 2 == 1 ? kThreshold : 0.0, 1 + round / 2);
      fall = std::max(fall, 1.0 - figures_of(mesh, flipper).least / before);
    }
    EXPECT_GT(repairer.counts().moves + repairer.counts().edges_removed, 0U) << seed;
  }
  return fall;
}

TEST(Repairer, NeverWorseHoldsForEveryMeansAndWithoutItTheWorstFalls) {
  EXPECT_LE(worst_fall(true), 1e-6);  // scores are ranked in single precision
  EXPECT_GT(worst_fall(false), 1e-3);
}

/// How many rounds on twelve meshes end with a lower least quality or a lower least dihedral angle than they
/// began with, though no single repair leaves a lower score than the least that it found around.
int count_falls(bool with_floor) {
  constexpr double kMostTets = 0.3;  // the score below which tets are repaired: most of these meshes
  int falls = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const SizingField no_field;
    WorkingMesh mesh = build_working_mesh(make_sliver_cube(6, seed), no_field);
    const double ideal = 1.0 / static_cast<double>(mesh.alive);
    const ScoreRule scores(scale_of_ideal_volume(ideal), no_field);
    QualityFloor before(ideal);
    RepairTools tools;
    tools.never_worse = true;
    Repairer repairer(mesh, scores, {}, tools);
    if (with_floor) repairer.set_floor(&before);
    for (int round = 0; round < 10; ++round) {
      before.take(mesh);
      repairer.round(kMostTets, round % 2 == 1 ? kMostTets : 0.0, 1 + round / 2);
      QualityFloor after(ideal);
      after.take(mesh);
      if (after.least_cube() < before.least_cube() || after.greatest_cosine() > before.greatest_cosine())
        ++falls;
    }
    EXPECT_GT(repairer.counts().moves + repairer.counts().edges_removed, 0U) << seed;
  }
  return falls;
}

TEST(Repairer, WithAFloorNeitherLeastQualityNorLeastAngleFalls) {
  EXPECT_EQ(count_falls(true), 0);
  EXPECT_GT(count_falls(false), 0);
}

}  // namespace
}  // namespace palpate::simplify

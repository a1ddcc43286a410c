#include "core/simplify/fusion/cheapest_first.h"

#include <gtest/gtest.h>

#include <string>

#include "core/base/error.h"
#include "core/judge/mesh/judge.h"
#include "core/mesh/shapes/shapes.h"
#include "tests/support/full_mode.h"
#include "tests/support/naive_cheapest_first.h"

namespace palpate::simplify {
namespace {

struct Case {
  const char* name;
  TetMesh mesh;
};

std::vector<Case> small_meshes() {
  return {{"kuhn cube, all ties", build_kuhn_cube(5, 0.0, 0)},
          {"jittered cube", build_kuhn_cube(6, 0.3, 3)},
          {"strongly jittered cube", build_kuhn_cube(6, 0.5, 11)},
          {"bcc bar", build_bcc_bar(4)}};
}

void expect_cheapest_as_naive(const TetMesh& input, const CheapestFirstOptions& options,
                              const std::string& what) {
  TetMesh fast = input;
  TetMesh naive = input;
  const SimplifyReport report = simplify_cheapest_first(fast, options);
  EXPECT_EQ(report.fusions, test_support::simplify_naively_cheapest_first(naive, options)) << what;
  EXPECT_EQ(fast, naive) << what;  // coordinates to the bit, and every index
}

TEST(CheapestFirst, SameBytesAsTheNaiveRescanWithEveryOption) {
  std::uint64_t fused = 0;
  for (const Case& c : small_meshes()) {
    for (const CostObjective objective : {CostObjective::kMovedLoss, CostObjective::kTotalLoss}) {
      for (const double drop : {0.0, 0.6}) {
        for (const int touched : {0, 1, 2}) {  // candidates again at once, in a further pass, never
          if (!test::is_full() && (touched == 1) != (drop > 0.0)) continue;  // each value of each option once
          CheapestFirstOptions options;
          options.objective = objective;
          options.common.drop = drop;
          options.common.skip_touched = touched != 0;
          options.many_passes = touched == 1;
          expect_cheapest_as_naive(c.mesh, options,
                                   std::string(c.name) + " objective " +
                                       std::to_string(static_cast<int>(objective)) + " drop " +
                                       std::to_string(drop) + " touched " + std::to_string(touched));
          TetMesh mesh = c.mesh;
          fused += simplify_cheapest_first(mesh, options).fusions;
        }
      }
    }
  }
  EXPECT_GT(fused, 500U);
}

TEST(CheapestFirst, SameBytesAsTheNaiveRescanWithOtherLevelsMetricsAndStops) {
  const TetMesh mesh = build_kuhn_cube(7, 0.35, 5);
  std::vector<CheapestFirstOptions> all(6);
  all[0].common.last_level = 2;
  all[1].common.metric = kMeanRatioMetric;
  all[2].common.levels = LevelAdjacency::kFace;
  all[2].common.last_level = 3;
  all[3].common.stop.fusions = 17;
  all[4].common.stop.tets = 1700;
  all[5].common.stop.ratio = 0.3;
  for (std::size_t i = 0; i < all.size(); ++i) expect_cheapest_as_naive(mesh, all[i], std::to_string(i));
}

TEST(CheapestFirst, SameBytesAsTheNaiveRescanWithARegionToKeep) {
  const std::vector<Case> cases{{"kuhn cube, all ties", build_kuhn_cube(4, 0.0, 0)},
                                {"jittered cube", build_kuhn_cube(5, 0.3, 3)}};
  for (const Case& c : cases) {
    for (const int touched : {0, 1, 2}) {
      CheapestFirstOptions options;
      options.common.skip_touched = touched != 0;
      options.many_passes = touched == 1;
      options.common.sizing.keep = {{.center = {0.5, 0.4, 0.3}, .radius = 0.02}};
      options.common.sizing.near_size = 0.4;
      options.common.sizing.reach = 0.5;
      const std::string what = std::string(c.name) + " touched " + std::to_string(touched);
      expect_cheapest_as_naive(c.mesh, options, what);
      options.common.stop.ratio = 0.2;
      expect_cheapest_as_naive(c.mesh, options, what + ", stopped");
      options.common.sizing.near_size = 1.0;
      expect_cheapest_as_naive(c.mesh, options, what + ", nothing graded");
    }
  }
}

TEST(CheapestFirst, TheJudgeFindsEveryTetThatWasToBeKept) {
  const TetMesh input = build_kuhn_cube(12, 0.3, 6);
  TetMesh output = input;
  CheapestFirstOptions options;
  options.common.sizing.keep = {{.center = {0.5, 0.5, 0.6}, .radius = 0.2}};
  const SimplifyReport report = simplify_cheapest_first(output, options);
  EXPECT_GT(report.fusions, 100U);
  EXPECT_GT(report.rejected.kept, 0U);
  const judge::Region region{judge::Region::Kind::kSphere, {0.5, 0.5, 0.6}, 0.2, 0.0};
  EXPECT_GT(judge::compare_in_regions(output, input, {&region, 1}).input_tets, 100U);
  EXPECT_EQ(judge::compare_in_regions(output, input, {&region, 1}).changed_tets, 0U);
  TetMesh free = input;
  simplify_cheapest_first(free, {});
  EXPECT_GT(judge::compare_in_regions(free, input, {&region, 1}).changed_tets, 0U);
}

TEST(CheapestFirst, ThreadsDoNotShow) {
  const TetMesh input = build_kuhn_cube(14, 0.35, 9);
  TetMesh expected;
  for (const int threads : {1, 2, 3}) {
    CheapestFirstOptions options;
    options.common.threads = threads;
    options.common.stop.ratio = 0.3;
    TetMesh output = input;
    simplify_cheapest_first(output, options);
    if (threads == 1) expected = output;
    EXPECT_EQ(output, expected) << threads << " threads";
  }
}

TEST(CheapestFirst, StorageOrderDoesNotShow) {
  const TetMesh input = build_kuhn_cube(12, 0.35, 9);
  CheapestFirstOptions options;
  TetMesh spatial = input;
  TetMesh plain = input;
  simplify_cheapest_first(spatial, options);
  options.common.storage = StorageOrder::kInput;
  simplify_cheapest_first(plain, options);
  EXPECT_EQ(spatial, plain);
}

TEST(CheapestFirst, TheJudgeFindsAValidMeshWithTheSameBoundary) {
  for (const bool skip_touched : {false, true}) {
    const TetMesh input = build_kuhn_cube(12, 0.4, 21);
    TetMesh mesh = input;
    CheapestFirstOptions options;
    options.common.skip_touched = skip_touched;
    const SimplifyReport report = simplify_cheapest_first(mesh, options);
    EXPECT_EQ(report.stop, "limit");
    EXPECT_GT(report.fusions, 100U);
    EXPECT_TRUE(judge::check_validity(mesh).is_valid());
    const judge::Comparison comparison = judge::compare_with_input(mesh, input);
    EXPECT_EQ(comparison.boundary_changed_faces, 0U);
    EXPECT_TRUE(comparison.euler_unchanged);
    // Each of n volumes of at most 1 is rounded to about 2^-52 of itself.
    EXPECT_LT(comparison.volume_drift_relative, 1e-12);
  }
}

TEST(CheapestFirst, EveryTetIsCountedByWhatKeepsIt) {
  TetMesh mesh = build_kuhn_cube(10, 0.3, 2);
  CheapestFirstOptions options;
  options.common.last_level = 2;
  const SimplifyReport report = simplify_cheapest_first(mesh, options);
  const Rejections& r = report.rejected;
  EXPECT_EQ(r.boundary + r.boundary_neighbour + r.quality + r.flip + r.touched, report.tets_out);
  EXPECT_EQ(report.tets_out, mesh.tets.size());
}

TEST(CheapestFirst, NothingToFuseLeavesTheMeshAsItIs) {
  const TetMesh input = build_kuhn_cube(2, 0.0, 0);
  TetMesh mesh = input;
  const SimplifyReport report = simplify_cheapest_first(mesh, {});
  EXPECT_EQ(report.fusions, 0U);
  EXPECT_EQ(report.stop, "limit");
  EXPECT_EQ(mesh, input);
}

TEST(CheapestFirst, RefusesImpossibleOptions) {
  TetMesh mesh = build_kuhn_cube(2, 0.0, 0);
  CheapestFirstOptions updated;
  updated.common.ideal_volume = IdealVolume::kUpdated;
  EXPECT_THROW(simplify_cheapest_first(mesh, updated), InputError);
  CheapestFirstOptions unchecked;
  unchecked.common.checks.flip = false;
  EXPECT_THROW(simplify_cheapest_first(mesh, unchecked), InputError);
  CheapestFirstOptions drop;
  drop.common.drop = 1.5;
  EXPECT_THROW(simplify_cheapest_first(mesh, drop), InputError);
}

}  // namespace
}  // namespace palpate::simplify

#include "core/simplify/refined/refined.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/judge/mesh/judge.h"
#include "core/mesh/shapes/shapes.h"
#include "core/mesh/topology.h"
#include "tests/support/refined_checks.h"
#include "tests/support/small_meshes.h"

namespace palpate::simplify {
namespace {

using namespace palpate::testing_support;  // NOLINT(google-build-using-namespace)

RefinedOptions stop_at(double ratio, int effort = 1) {
  RefinedOptions options;
  options.stop.ratio = ratio;
  options.effort = effort;
  return options;
}

struct Result {
  TetMesh mesh;
  RefinedReport report;
};

Result run(const TetMesh& input, const RefinedOptions& options) {
  Result result{input, {}};
  result.report = simplify_refined(result.mesh, options);
  EXPECT_EQ(result.report.tets_in, input.tets.size());
  EXPECT_EQ(result.report.tets_out, result.mesh.tets.size());
  EXPECT_EQ(result.report.vertices_out, result.mesh.points.size());
  expect_valid_with_boundary_of(result.mesh, input);
  return result;
}

/// What the count may fall short of: 0.5%, or one collapse where that is more.
void expect_count_met(const Result& result, std::uint64_t target) {
  EXPECT_LE(result.mesh.tets.size(), target);
  const double short_by = static_cast<double>(target - result.mesh.tets.size());
  EXPECT_LE(short_by, std::max(0.005 * static_cast<double>(target), 12.0));
}

/// As the adapter runs it.
Result run_as_far_as_it_goes(const TetMesh& input, const RefinedOptions& options) {
  RefinedOptions first = options;
  first.abandon_beyond = kShort;
  Result result = run(input, first);
  if (result.report.stop != "limit") return result;
  result.mesh = input;
  result.report = simplify_to_limit(result.mesh, options);
  EXPECT_EQ(result.report.stop, "limit");
  EXPECT_EQ(result.report.tets_in, input.tets.size());
  EXPECT_EQ(result.report.tets_out, result.mesh.tets.size());
  expect_valid_with_boundary_of(result.mesh, input);
  return result;
}

TEST(Refined, WhatIsAbandonedCouldNotBeReachedAndTheRestIsTheSame) {
  std::size_t abandoned = 0;
  std::size_t reached = 0;
  for (const TetMesh& input : {build_kuhn_cube(6, 0.2, 4), make_sliver_cube(5, 2)}) {
    for (const double ratio : {0.3, 0.5, 0.65, 0.7, 0.75, 0.9}) {
      SCOPED_TRACE(std::to_string(input.tets.size()) + " " + std::to_string(ratio));
      RefinedOptions options = stop_at(ratio);
      const Result whole = run(input, options);
      options.abandon_beyond = kShort;
      const Result part = run(input, options);  // valid in any case
      EXPECT_EQ(part.report.stop, whole.report.stop);
      const bool is_same = part.mesh.points == whole.mesh.points && part.mesh.tets == whole.mesh.tets;
      if (whole.report.stop != "limit") {
        ++reached;
        EXPECT_TRUE(is_same);
      }
      abandoned += is_same ? 0 : 1;
    }
  }
  EXPECT_GT(reached, 3U);
  EXPECT_GT(abandoned, 1U);
}

TEST(Refined, AskingForLessNeverLeavesMore) {
  for (const TetMesh& input :
       {build_kuhn_cube(5, 0.3, 1), build_kuhn_cube(6, 0.2, 4), make_sliver_cube(5, 2)}) {
    std::size_t least = input.tets.size();
    std::size_t limits = 0;
    for (const double ratio : {0.2, 0.4, 0.5, 0.6, 0.65, 0.7, 0.75, 0.8, 0.9, 0.99}) {
      SCOPED_TRACE(std::to_string(input.tets.size()) + " " + std::to_string(ratio));
      const Result result = run_as_far_as_it_goes(input, stop_at(ratio));
      EXPECT_LE(result.mesh.tets.size(), least);
      least = result.mesh.tets.size();
      limits += result.report.stop == "limit" ? 1 : 0;
    }
    EXPECT_GT(limits, 1U);  // else nothing was shown
  }
}

TEST(Refined, MeetsTheCountWithTheBoundaryUntouched) {
  const std::vector<TetMesh> inputs{build_kuhn_cube(9, 0.3, 1), build_bcc_bar(6), make_sliver_cube(9, 4)};
  for (const TetMesh& input : inputs) {
    for (const double ratio : {0.05, 0.22, 0.5}) {
      SCOPED_TRACE(std::to_string(input.tets.size()) + " " + std::to_string(ratio));
      const Result result = run(input, stop_at(ratio));
      const auto target = target_tet_count(stop_at(ratio).stop, input.tets.size());
      expect_count_met(result, target);
      EXPECT_EQ(result.report.stop, "ratio");
      EXPECT_GT(result.report.collapses.collapses, 0U);
    }
  }
}

TEST(Refined, IsNeverBelowItsInputAt22Percent) {
  for (const TetMesh& input : {build_kuhn_cube(9, 0.3, 7), make_sliver_cube(9, 2)}) {
    const judge::Quality before = judge::measure_quality(input);
    const judge::Quality after = judge::measure_quality(run(input, stop_at(0.22)).mesh);
    EXPECT_GE(after.percent_above_0_5, before.percent_above_0_5);
    EXPECT_GE(after.percent_above_0_6, before.percent_above_0_6);
    EXPECT_GE(after.mean_quality, before.mean_quality);
    EXPECT_GE(after.min_dihedral_deg, before.min_dihedral_deg);
    EXPECT_GE(after.p1_dihedral_deg, before.p1_dihedral_deg);
  }
}

TEST(Refined, SameBytesTwice) {
  const TetMesh input = make_sliver_cube(8, 5);
  for (const int effort : {0, 1, 3}) {
    EXPECT_EQ(run(input, stop_at(0.4, effort)).mesh, run(input, stop_at(0.4, effort)).mesh);
  }
}

TEST(Refined, ScalingByAPowerOfTwoScalesTheResult) {
  const TetMesh input = build_kuhn_cube(8, 0.3, 6);
  const TetMesh expected = run(input, stop_at(0.5)).mesh;
  for (const double factor : {0x1.0p-40, 0x1.0p30}) {
    TetMesh scaled = input;
    for (Vec3& p : scaled.points) p = factor * p;
    TetMesh result = run(scaled, stop_at(0.5)).mesh;
    for (Vec3& p : result.points) p = (1.0 / factor) * p;
    EXPECT_EQ(result, expected);
  }
}

TEST(Refined, EveryEffortIsValidAndMoreEffortIsBetterInTheMean) {
  const TetMesh input = build_kuhn_cube(12, 0.35, 8);
  std::vector<double> mean;
  for (int effort = 0; effort <= kMostEffort; ++effort) {
    mean.push_back(judge::measure_quality(run(input, stop_at(0.5, effort)).mesh).mean_quality);
  }
  EXPECT_GT(mean[1], mean[0]);
  EXPECT_GT(mean[3], mean[1]);
  EXPECT_GT(mean[5], mean[1]);  // 3 and 5 are a few tenths of a percent apart, either way
}

/// What shape is for, and what it costs of the thesis's quality.
TEST(Refined, ShapeRaisesRatiosAndLowersTheGreatestAngles) {
  for (const TetMesh& input : {build_kuhn_cube(10, 0.3, 5), make_sliver_cube(8, 3)}) {
    for (const double ratio : {0.3, 0.5}) {
      SCOPED_TRACE(std::to_string(input.tets.size()) + " " + std::to_string(ratio));
      RefinedOptions options = stop_at(ratio);
      ASSERT_EQ(options.objective, Objective::kShape);
      const judge::Quality shape = judge::measure_quality(run(input, options).mesh);
      options.objective = Objective::kQuality;
      const judge::Quality quality = judge::measure_quality(run(input, options).mesh);
      EXPECT_GT(shape.mean_ratio.mean, quality.mean_ratio.mean);
      EXPECT_GT(shape.mean_ratio.p5, quality.mean_ratio.p5);
      EXPECT_GT(shape.radius_ratio.mean, quality.radius_ratio.mean);  // which neither raises
      EXPECT_LT(shape.p99_max_dihedral_deg, quality.p99_max_dihedral_deg);
      EXPECT_GT(shape.percent_above_0_5, quality.percent_above_0_5 - 3.0);
    }
  }
}

TEST(Refined, EachIngredientCanBeLeftOut) {
  const TetMesh input = make_sliver_cube(7, 6);
  const TetMesh whole = run(input, stop_at(0.4)).mesh;
  const std::vector<bool RefinedOptions::*> switches{&RefinedOptions::interleave, &RefinedOptions::repair};
  const std::vector<bool RepairTools::*> tools{&RepairTools::smoothing, &RepairTools::edge_removal,
                                               &RepairTools::face_removal, &RepairTools::compound_moves,
                                               &RepairTools::edge_splits};
  for (const auto member : switches) {
    RefinedOptions options = stop_at(0.4);
    options.*member = false;
    EXPECT_NE(run(input, options).mesh, whole);
  }
  for (const auto member : tools) {
    RefinedOptions options = stop_at(0.4);
    options.tools.*member = false;
    const Result result = run(input, options);
    if (member == &RepairTools::smoothing) {
      EXPECT_EQ(result.report.counts.moves, 0U);
    }
    if (member == &RepairTools::edge_removal) {
      EXPECT_EQ(result.report.counts.edges_removed, 0U);
    }
    if (member == &RepairTools::face_removal) {
      EXPECT_EQ(result.report.counts.faces_removed, 0U);
    }
    if (member == &RepairTools::edge_splits) {
      EXPECT_EQ(result.report.counts.splits, 0U);
    }
  }
  for (const CollapsePlacement placement : {CollapsePlacement::kBest, CollapsePlacement::kMidpoint}) {
    RefinedOptions options = stop_at(0.4);
    options.collapse_placement = placement;
    EXPECT_NE(run(input, options).mesh, whole);
  }
}

TEST(Refined, LeavesAMeshThatIsSmallEnoughAsItIs) {
  const TetMesh input = build_kuhn_cube(4, 0.3, 1);
  EXPECT_EQ(run(input, stop_at(0.0)).mesh, input);
  RefinedOptions options;
  options.stop.tets = input.tets.size() + 10;
  const Result result = run(input, options);
  EXPECT_EQ(result.mesh, input);
  EXPECT_EQ(result.report.stop, "tets");
}

TEST(Refined, SaysLimitWhereTheCountCannotBeReached) {
  RefinedOptions options;
  options.stop.tets = 1;
  for (const TetMesh& input : {build_kuhn_cube(4, 0.2, 1), make_regular_tet(), make_hollow_cube()}) {
    if (input.tets.size() == 1) {
      EXPECT_EQ(run(input, options).mesh, input);
      continue;
    }
    EXPECT_EQ(run(input, options).report.stop, "limit");
  }
}

TEST(Refined, KeptRegionsStayToTheBit) {
  const TetMesh input = build_kuhn_cube(12, 0.3, 3);
  RefinedOptions options = stop_at(0.5);
  options.sizing.keep.push_back(
      {.kind = KeptRegion::Kind::kSphere, .center = {0.3, 0.4, 0.5}, .radius = 0.2});
  const SizingField field(options.sizing, input);
  const std::vector<std::uint8_t> kept = build_kept_tets(field, input);
  const TetMesh output = run(input, options).mesh;
  const auto corners = [](const TetMesh& mesh, const Tet& t) {
    std::array<std::array<double, 3>, 4> p{};
    for (std::size_t i = 0; i < 4; ++i)
      p[i] = {mesh.points[t[i]].x, mesh.points[t[i]].y, mesh.points[t[i]].z};
    return p;
  };
  std::set<std::array<std::array<double, 3>, 4>> found;
  for (const Tet& t : output.tets) found.insert(corners(output, t));
  std::size_t count = 0;
  for (std::size_t t = 0; t < input.tets.size(); ++t) {
    if (kept[t] == 0) continue;
    ++count;
    EXPECT_TRUE(found.count(corners(input, input.tets[t])) == 1) << t;
  }
  EXPECT_GT(count, 50U);
  // Finer near the region than far from it, where neither the boundary nor what is kept decides.
  const std::vector<std::uint8_t> on_boundary = build_boundary_vertex_flags(output);
  double near = 0.0;
  double far = 0.0;
  std::array<std::size_t, 2> n{};
  for (const Edge& e : build_edges(output)) {
    const double d = field.distance(0.5 * (output.points[e[0]] + output.points[e[1]]));
    const double l = length(output.points[e[1]] - output.points[e[0]]);
    if (on_boundary[e[0]] != 0 || on_boundary[e[1]] != 0) continue;
    if (d > 0.05 && d < 0.12) {
      near += l;
      ++n[0];
    } else if (d > 0.35) {
      far += l;
      ++n[1];
    }
  }
  EXPECT_LT(near / static_cast<double>(n[0]), far / static_cast<double>(n[1]));
}

TEST(Refined, HandlesCavitiesAndSeveralComponentsStayAsTheyAre) {
  std::vector<Cell> cells;
  for (int x = 0; x < 7; ++x) {
    for (int y = 0; y < 7; ++y) {
      for (int z = 0; z < 5; ++z) {
        const bool hole = (x == 3 && y == 3) || (x == 5 && y == 5 && z == 2) || x == 7;
        if (!hole) cells.push_back({x, y, z});
      }
    }
  }
  const TetMesh one = make_kuhn_cells(cells);
  const TetMesh input = join_meshes(one, translated(one, {40.0, 0.0, 1e6}));
  run(input, stop_at(0.2));
}

/// Vertices pushed to within `distance` of the plane of a face around them.
TetMesh flatten(TetMesh mesh, double distance, std::uint64_t seed) {
  const std::vector<std::uint8_t> on_boundary = build_boundary_vertex_flags(mesh);
  SplitMix64 random(seed);
  for (Tet& t : mesh.tets) {
    if (random.uniform() > 0.05) continue;
    const std::size_t i = random.below(4);
    if (on_boundary[t[i]] != 0) continue;
    const Vec3& a = mesh.points[t[(i + 1) % 4]];
    const Vec3& b = mesh.points[t[(i + 2) % 4]];
    const Vec3& c = mesh.points[t[(i + 3) % 4]];
    const Vec3 foot = (1.0 / 3.0) * (a + b + c);
    const Vec3 before = mesh.points[t[i]];
    mesh.points[t[i]] = foot + distance * (before - foot);
    if (judge::check_validity(mesh).inverted_tets + judge::check_validity(mesh).flat_tets > 0) {
      mesh.points[t[i]] = before;
    }
  }
  return mesh;
}

TEST(Refined, SurvivesNearlyDegenerateInput) {
  for (const double distance : {1e-6, 1e-11, 1e-14}) {
    for (const double shift : {0.0, 1e3}) {
      SCOPED_TRACE(std::to_string(distance) + " " + std::to_string(shift));
      const TetMesh input =
          flatten(translated(build_kuhn_cube(5, 0.2, 9), {shift, -shift, 0.5 * shift}), distance, 3);
      ASSERT_TRUE(judge::check_validity(input).is_valid());
      const Result result = run(input, stop_at(0.3, 2));
      EXPECT_GE(judge::measure_quality(result.mesh).min_dihedral_deg,
                judge::measure_quality(input).min_dihedral_deg);
    }
  }
}

TEST(Refined, RefusesWhatMakesNoSense) {
  TetMesh mesh = build_kuhn_cube(3, 0.0, 0);
  const auto refuse = [&](const RefinedOptions& options) {
    EXPECT_THROW(simplify_refined(mesh, options), InputError);
  };
  refuse(stop_at(1.0));
  refuse(stop_at(-0.1));
  refuse(stop_at(std::nan("")));
  refuse(stop_at(0.5, -1));
  refuse(stop_at(0.5, kMostEffort + 1));
  refuse(RefinedOptions{});
  RefinedOptions fusions;
  fusions.stop.fusions = 5;
  refuse(fusions);
  EXPECT_EQ(mesh, build_kuhn_cube(3, 0.0, 0));
}

}  // namespace
}  // namespace palpate::simplify

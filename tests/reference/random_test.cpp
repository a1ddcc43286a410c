#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/judge/mesh/judge.h"
#include "core/mesh/shapes/shapes.h"
#include "core/simplify/quality/quality.h"
#include "reference/random/edge_collapse.h"

namespace palpate::reference {
namespace {

double worst_quality(const TetMesh& mesh) {
  constexpr simplify::QualityMetric kMetric{simplify::thesis_shape, false};
  double worst = 2.0;
  for (const Tet& t : mesh.tets) {
    const auto f = simplify::measure_tet(kMetric, mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]],
                                         mesh.points[t[3]]);
    worst = std::min(worst, f.is_positive ? simplify::quality_factor(kMetric, f, 1.0) : -1.0);
  }
  return worst;
}

TEST(RandomEdgeCollapse, NoTetFallsBelowTheLastGuardOrTheWorstBefore) {
  for (const double jitter : {0.0, 0.4}) {
    for (const Placement placement : {Placement::kBest, Placement::kMidpoint}) {
      const TetMesh input = build_kuhn_cube(8, jitter, 5);
      TetMesh output = input;
      EdgeCollapseOptions options;
      options.first_guard = 0.5;
      options.last_guard = 0.35;
      options.placement = placement;
      const EdgeCollapseReport report = collapse_random_edges(output, options);
      EXPECT_GT(report.collapses, 50U);
      // The guard compares cubes: one rounding of the root more.
      EXPECT_GE(worst_quality(output), std::min(worst_quality(input), 0.35) * (1.0 - 1e-14));
      EXPECT_TRUE(judge::check_validity(output).is_valid());
      EXPECT_EQ(judge::compare_with_input(output, input).boundary_changed_faces, 0U);
    }
  }
}

TEST(RandomEdgeCollapse, EachCollapseTakesOneVertexAndStopsAtTheFirstStateThatWillDo) {
  const TetMesh input = build_kuhn_cube(8, 0.2, 3);
  TetMesh output = input;
  EdgeCollapseOptions options;
  options.target_tets = input.tets.size() - 100;
  const EdgeCollapseReport report = collapse_random_edges(output, options);
  EXPECT_TRUE(report.reached_target);
  EXPECT_EQ(input.points.size() - output.points.size(), report.collapses);
  EXPECT_LE(output.tets.size(), options.target_tets);
  options.target_tets = output.tets.size() + 1;
  TetMesh earlier = input;
  EXPECT_EQ(collapse_random_edges(earlier, options).collapses, report.collapses);
}

TEST(RandomEdgeCollapse, AnEdgeWithABoundaryEndGoesThere) {
  // The block's one inner vertex: every edge that may go has its other end on the boundary.
  const TetMesh input = build_kuhn_cube(2, 0.0, 0);
  TetMesh output = input;
  EdgeCollapseOptions options;
  options.last_guard = 0.0;
  const EdgeCollapseReport report = collapse_random_edges(output, options);
  EXPECT_EQ(report.collapses, 1U);
  EXPECT_EQ(output.points.size(), 26U);
  EXPECT_TRUE(judge::check_validity(output).is_valid());
  EXPECT_EQ(judge::compare_with_input(output, input).boundary_changed_faces, 0U);
}

}  // namespace
}  // namespace palpate::reference

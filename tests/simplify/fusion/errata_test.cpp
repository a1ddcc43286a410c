// What the thesis says of fusion and what is so; docs/errata.md names these tests.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "core/mesh/orientation.h"
#include "core/mesh/shapes/shapes.h"
#include "core/simplify/fusion/fusion.h"
#include "core/simplify/fusion/hierarchical.h"

namespace palpate::simplify {
namespace {

TEST(Errata, TheFlipTestOfTheThesisLetsFlatTetsThrough) {
  // Check 4 refuses when (n . Rb1)(n . Rb2) < 0. Here the moved vertex lands in the plane x + y - z = 1/4 of
  // its base.
  const std::array<Vec3, 4> target{Vec3{0, 0, 0}, Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};
  const Vec3 barycenter = 0.25 * (target[0] + target[1] + target[2] + target[3]);
  const std::array<Vec3, 3> base{Vec3{-1, 2, 0.75}, Vec3{2, -1, 0.75}, Vec3{-1, -1, -2.25}};
  const Vec3 normal = cross(base[1] - base[0], base[2] - base[0]);
  const double before = dot(normal, target[0] - base[0]);
  const double after = dot(normal, barycenter - base[0]);
  EXPECT_NE(before, 0.0);
  EXPECT_FALSE(before * after < 0.0);                                // so the thesis accepts it,
  EXPECT_EQ(orientation(base[0], base[1], base[2], barycenter), 0);  // though nothing is left of the tet
  EXPECT_FALSE(measure_tet(kThesisMetric, base[0], base[1], base[2], barycenter).is_positive);
}

TEST(Errata, OneEdgeCollapseRemovesAWholeRingOfTets) {
  // 2.3.9 counts six edge collapses for one tet. One collapse of an interior edge removes every tet around
  // the edge.
  const TetMesh mesh = build_kuhn_cube(4, 0.2, 1);
  const auto on_boundary = build_boundary_vertex_flags(mesh);
  std::map<Edge, int> ring;
  for (const Tet& tet : mesh.tets) {
    for (const auto& [i, j] : kTetEdges) ++ring[{std::min(tet[i], tet[j]), std::max(tet[i], tet[j])}];
  }
  int least = 1000;
  for (const auto& [edge, tets] : ring) {
    if (on_boundary[edge[0]] == 0 && on_boundary[edge[1]] == 0) least = std::min(least, tets);
  }
  EXPECT_GE(least, 4);
}

TEST(Errata, AHundredthOfTheFormerQualityRefusesAlmostNothing) {
  // Check 3 with the thesis's 1/100 against check 4 on the same mesh.
  TetMesh mesh = build_kuhn_cube(16, 0.4, 3);
  const SimplifyReport report = simplify_hierarchical(mesh, {});
  EXPECT_GT(report.fusions, 300U);
  EXPECT_LT(100 * report.rejected.quality, report.rejected.flip);
}

TEST(Errata, TheCounterOfTheLevelWouldEndItTooEarly) {
  // Step 3 lowers the level's counter n by all tets that die with the target, though some are of other
  // levels.
  const TetMesh mesh = build_kuhn_cube(12, 0.3, 3);
  const auto on_boundary = build_boundary_vertex_flags(mesh);
  const FusionMesh work = build_fusion_mesh(TetMesh(mesh), StorageOrder::kInput);
  const auto level = build_levels(work, on_boundary, LevelAdjacency::kVertex);
  FusionPlan plan;
  std::size_t dead_of_other_levels = 0;
  for (Index t = 0; t < mesh.tets.size(); ++t) {
    if (level[t] < 2) continue;
    plan_fusion(work, t, plan);
    dead_of_other_levels += static_cast<std::size_t>(
        std::count_if(plan.dead.begin(), plan.dead.end(), [&](Index d) { return level[d] != level[t]; }));
  }
  EXPECT_GT(dead_of_other_levels, 0U);
}

TEST(Errata, TheThesisCountsAmountToEightySevenFusions) {
  // 1503 vertices became 1242: three fewer a fusion. Euler's formula then gives the tets from edges and
  // vertices: F = 2 T + B / 2 and V - E + F - T = 1 give T = 1 - V + E - B / 2, and B, the boundary's faces,
  // does not change.
  EXPECT_EQ((1503 - 1242) % 3, 0);
  EXPECT_EQ((1503 - 1242) / 3, 87);
  EXPECT_EQ((9998 - 1503) - (7959 - 1242), 1778);
  TetMesh mesh = build_kuhn_cube(12, 0.3, 3);
  const std::size_t edges = build_edges(mesh).size();
  const std::size_t vertices = mesh.points.size();
  SimplifyOptions options;
  options.stop.fusions = 40;
  const SimplifyReport report = simplify_hierarchical(mesh, options);
  EXPECT_EQ(vertices - mesh.points.size(), 3 * report.fusions);
  EXPECT_EQ((edges - vertices) - (build_edges(mesh).size() - mesh.points.size()),
            report.tets_in - report.tets_out);
}

}  // namespace
}  // namespace palpate::simplify

// Collapses of inner edges: which least score is asked for when, and that nothing that could go is passed
// over.
#include "core/simplify/tet_operations/edge_collapse.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "core/mesh/shapes/shapes.h"
#include "core/simplify/sizing/sizing.h"
#include "core/simplify/tet_operations/shortest_edges.h"
#include "tests/support/refined_checks.h"

namespace palpate::simplify {
namespace {

using namespace palpate::testing_support;  // NOLINT(google-build-using-namespace)

constexpr std::array kLeastScores{1e-2, 1e-3, 1e-4, 1e-6, 1e-9};

const SizingField kNoField({}, TetMesh{});

struct Collapsed {
  WorkingMesh mesh;
  ScoreRule rule;
  CollapseReport report;

  double worst() const {
    double least = 1.0;
    const TetMesh left = copy_of(mesh);
    const auto& p = left.points;
    for (const Tet& t : left.tets)
      least = std::min(least, double{score_tet(rule.far(), p[t[0]], p[t[1]], p[t[2]], p[t[3]])});
    return least;
  }
};

Collapsed collapse(const TetMesh& input, std::span<const double> least_scores, std::uint64_t target,
                   CollapsePlacement placement = CollapsePlacement::kFirst) {
  const double volume = 2.0 * graded_volume(input, kNoField) / static_cast<double>(input.tets.size());
  Collapsed done{build_working_mesh(TetMesh(input), kNoField),
                 ScoreRule(scale_of_ideal_volume(volume, ScoreForm::kMeanRatio), kNoField),
                 {}};
  CollapseOptions options;
  options.least_scores = least_scores;
  options.target = target;
  options.placement = placement;
  done.report = collapse_edges(done.mesh, done.rule, options);
  return done;
}

TEST(EdgeCollapse, ALowerScoreIsPermittedOnlyWhereTheStricterLeavesNothing) {
  const TetMesh input = build_kuhn_cube(6, 0.2, 4);
  for (std::size_t levels = 1; levels < kLeastScores.size(); ++levels) {
    SCOPED_TRACE(levels);
    const auto strict = std::span(kLeastScores).first(levels);
    const Collapsed fewest = collapse(input, strict, 0);
    ASSERT_LT(fewest.mesh.alive, input.tets.size());
    EXPECT_GT(fewest.worst(), strict.back());
    // What the stricter scores reach is the same whatever is permitted after them.
    const Collapsed same = collapse(input, kLeastScores, fewest.mesh.alive);
    EXPECT_EQ(copy_of(same.mesh).points, copy_of(fewest.mesh).points);
    EXPECT_EQ(copy_of(same.mesh).tets, copy_of(fewest.mesh).tets);
    // One tetrahedron fewer takes the next score that reaches it, which is not the last one at once.
    const Collapsed next = collapse(input, kLeastScores, fewest.mesh.alive - 1);
    ASSERT_LT(next.mesh.alive, fewest.mesh.alive);
    const auto below = std::find_if(kLeastScores.begin(), kLeastScores.end(),
                                    [&](double least) { return next.worst() > least; });
    ASSERT_NE(below, kLeastScores.end());
    const auto tried = static_cast<std::size_t>(below - kLeastScores.begin());
    EXPECT_EQ(collapse(input, std::span(kLeastScores).first(tried), 0).mesh.alive > next.mesh.alive,
              tried > 0);
  }
}

/// How many edges to a vertex that stays could still go, looked at one by one.
std::size_t count_collapsible(Collapsed& done) {
  WorkingMesh& mesh = done.mesh;
  VertexMarks marks;
  std::vector<Index> neighbours;
  std::size_t found = 0;
  for (Index gone = 0; gone < mesh.points.size(); ++gone) {
    if (!mesh.is_vertex_alive(gone) || !mesh.is_free(gone)) continue;
    collect_neighbours(mesh, gone, marks, neighbours);
    for (const Index survivor : std::vector(neighbours)) {
      if (mesh.is_free(survivor)) continue;
      double worst = 1.0;
      for (const Index t : mesh.star(gone)) {
        std::array<Vec3, 4> p{};
        bool dies = false;
        for (std::size_t i = 0; i < 4; ++i) {
          const Index v = mesh.tets[t][i];
          dies = dies || v == survivor;
          p[i] = mesh.points[v == gone ? survivor : v];
        }
        if (!dies) worst = std::min(worst, double{score_tet(done.rule.far(), p[0], p[1], p[2], p[3])});
      }
      if (worst > kLeastScores.back() && meets_link_condition(mesh, gone, survivor, marks)) ++found;
    }
  }
  return found;
}

TEST(EdgeCollapse, NothingThatCouldGoIsPassedOver) {
  for (const TetMesh& input : {build_kuhn_cube(6, 0.2, 4), make_sliver_cube(5, 2)}) {
    Collapsed before = collapse(input, {}, 0);
    ASSERT_GT(count_collapsible(before), 0U);
    for (const CollapsePlacement placement :
         {CollapsePlacement::kFirst, CollapsePlacement::kBest, CollapsePlacement::kMidpoint}) {
      Collapsed done = collapse(input, kLeastScores, 0, placement);
      ASSERT_GT(done.report.collapses, 0U);
      expect_consistent(done.mesh);
      EXPECT_EQ(count_collapsible(done), 0U);
      // All edges are looked at anew by a second run.
      CollapseOptions options;
      options.least_scores = std::span(kLeastScores).last(1);
      options.placement = placement;
      const CollapseReport again = collapse_edges(done.mesh, done.rule, options);
      EXPECT_EQ(again.collapses, 0U);
      EXPECT_GT(again.rejected_shape + again.rejected_link, 0U);
    }
  }
}

TEST(EdgeCollapse, WithoutALeastScoreNothingCollapses) {
  const TetMesh input = build_kuhn_cube(3, 0.1, 1);
  EXPECT_EQ(collapse(input, {}, 0).mesh.alive, input.tets.size());
}

}  // namespace
}  // namespace palpate::simplify

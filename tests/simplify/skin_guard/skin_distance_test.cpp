#include "core/simplify/skin_guard/skin_distance.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/judge/surface/surface.h"
#include "core/simplify/surface/surface_smoothing.h"
#include "tests/support/moved_top.h"
#include "tests/support/rough_skin.h"

namespace palpate::simplify {
namespace {

using namespace palpate::testing_support;  // NOLINT(google-build-using-namespace)

struct Top : MovedTop {
  GuardedBoundary boundary{mesh, 0.2};

  /// Whether it may go there; it does, then.
  bool go_to(double height) {
    const BoundaryChange change = to(boundary, {2, 2, height});
    if (boundary.check(mesh, change) != BoundaryVerdict::kAllowed) return false;
    boundary.apply(change);
    apply_move(mesh, middle, change.to);
    return true;
  }

  /// The greatest of what the input's triangles and the faces are said to be off.
  double reach_of_inputs() const {
    double greatest = 0.0;
    for (Index i = 0; i < boundary.distance().input().size(); ++i)
      greatest = std::max(greatest, boundary.distance().coverage().reach_of_input(i));
    return greatest;
  }
  double reach_of_faces() const {
    double greatest = 0.0;
    for (Index f = 0; f < boundary.slots(); ++f)
      greatest = std::max(greatest, boundary.distance().coverage().reach_of_face(f));
    return greatest;
  }
};

TEST(SkinDistance, ShiftsAddUpUntilTheBoundAndThenTheDistanceIsProvenAnew) {
  Top top;
  const double heights[] = {4.06, 4.0, 4.06, 4.0};
  const double sums[] = {0.06, 0.12, 0.18, 0.0};  // the fourth would be 0.24, beyond the bound
  for (std::size_t k = 0; k < 4; ++k) {
    ASSERT_TRUE(top.go_to(heights[k]));
    EXPECT_NEAR(top.reach_of_inputs(), sums[k], 1e-5) << k;
    EXPECT_NEAR(top.reach_of_faces(), sums[k], 1e-5) << k;
  }
  EXPECT_TRUE(top.go_to(4.19));
  EXPECT_FALSE(top.go_to(4.21));
  EXPECT_TRUE(top.go_to(3.85));  // a shift of 0.34: only the proof says yes
  EXPECT_NEAR(top.reach_of_inputs(), 0.15, 1e-5);
}

/// Holds all that is said of single triangles and faces by the judge's arithmetic.
void expect_true_reaches(const GuardedSkin& skin, double bound) {
  const SkinDistance& distance = skin.boundary.distance();
  const Coverage& coverage = distance.coverage();
  const SurfaceMesh input = judge::build_boundary(skin.input);
  for (Index i = 0; i < distance.input().size(); ++i) {
    const TriangleCorners& t = distance.input().triangle(i).corner;
    const SurfaceMesh one{{t[0], t[1], t[2]}, {{0, 1, 2}}};
    SurfaceMesh over{skin.mesh.points, {}};
    for (const Index f : coverage.covering(i)) {
      ASSERT_TRUE(skin.boundary.is_alive(f));
      over.triangles.push_back(skin.boundary.face(f));
    }
    ASSERT_FALSE(over.triangles.empty());
    EXPECT_LE(judge::measure_surface_distance(one, over).forward.lower, coverage.reach_of_input(i));
    EXPECT_LE(coverage.reach_of_input(i), bound);
  }
  for (Index f = 0; f < skin.boundary.slots(); ++f) {
    if (!skin.boundary.is_alive(f)) continue;
    const SurfaceMesh one{skin.mesh.points, {skin.boundary.face(f)}};
    EXPECT_LE(judge::measure_surface_distance(one, input).forward.lower, coverage.reach_of_face(f));
    EXPECT_LE(coverage.reach_of_face(f), bound);
  }
}

TEST(SkinDistance, WhatIsSaidOfEachTriangleAndFaceStandsBeforeTheJudge) {
  for (const double bound : {0.15, 0.4, 1.0}) {
    GuardedSkin skin(make_rough_block(7), bound);
    SurfaceCollapseOptions options;
    options.least_score = 1e-3;
    const std::size_t faces = skin.boundary.size();
    for (const double share : {0.8, 0.6, 0.5}) {
      options.face_target = static_cast<std::uint64_t>(share * static_cast<double>(faces));
      collapse_boundary_edges(skin.mesh, skin.boundary, skin.scores, options, skin.report);
      smooth_boundary(skin.mesh, skin.boundary, skin.scores, skin.volume(), skin.report);
    }
    expect_true_reaches(skin, bound);
    EXPECT_GT(skin.report.collapses + skin.report.moves, 20U) << bound;
    skin.judged(bound);
  }
}

}  // namespace
}  // namespace palpate::simplify

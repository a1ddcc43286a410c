// A longer stable step: what holds it down is known, and let go of, with everything else kept.
#include "core/simplify/refined/stable_step.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/judge/linear_elements/linear_elements.h"
#include "core/judge/surface/feature_distance.h"
#include "core/mesh/geometry.h"
#include "core/mesh/shapes/shapes.h"
#include "core/mesh/topology.h"
#include "core/simplify/refined/body_rate.h"
#include "core/simplify/refined/refined.h"
#include "core/simplify/surface/surface.h"
#include "core/simplify/surface/surface_smoothing.h"
#include "tests/support/refined_checks.h"
#include "tests/support/rough_skin.h"
#include "tests/support/small_meshes.h"

namespace palpate::simplify {
namespace {

using namespace palpate::testing_support;  // NOLINT(google-build-using-namespace)

TetMesh simplify_for(const TetMesh& input, Objective objective, double ratio) {
  TetMesh mesh = input;
  RefinedOptions options;
  options.stop.ratio = ratio;
  options.objective = objective;
  const RefinedReport report = simplify_refined(mesh, options);
  EXPECT_EQ(report.stop, "ratio");
  return mesh;
}

/// Each tet in four, at its middle: the skin stays, and is coarser than the inside.
TetMesh split_tets(const TetMesh& mesh) {
  TetMesh split;
  split.points = mesh.points;
  for (const Tet& tet : mesh.tets) {
    const auto middle = static_cast<Index>(split.points.size());
    Vec3 sum{};
    for (const Index v : tet) sum = sum + mesh.points[v];
    split.points.push_back(0.25 * sum);
    for (std::size_t k = 0; k < tet.size(); ++k) {
      Tet part = tet;
      part[k] = middle;
      split.tets.push_back(part);
    }
  }
  return split;
}

TetMesh regular_tet(double edge) {
  TetMesh mesh = make_regular_tet();
  const double size = length(mesh.points[1] - mesh.points[0]);
  for (Vec3& p : mesh.points) p = (edge / size) * p;
  return mesh;
}

double judged_step(const TetMesh& mesh) {
  const judge::LinearElementFigures figures = judge::measure_linear_elements(mesh);
  EXPECT_EQ(figures.reason, "");
  return figures.explicit_step;
}

TEST(StableStep, ARegularTetIsKnown) {
  // All altitudes h = a sqrt(2 / 3): S = V n n^T / h^2, so the rate is (2.5 + 1) 4 / h^2 = 21 / a^2.
  const double a = 0.7;
  const WorkingMesh working = build_working_mesh(regular_tet(a), SizingField());
  for (Index v = 0; v < 4; ++v)
    EXPECT_NEAR(measure_vertex(working, v).rate(), 21.0 / (a * a), 1e-11 / (a * a));
}

TEST(StableStep, TheGreatestRateBoundsTheJudgesStep) {
  for (const TetMesh& mesh :
       {build_kuhn_cube(4, 0.3, 1), build_kuhn_cube(6, 0.2, 4), build_kuhn_cube(5, 0.0, 1)}) {
    const double shear_modulus = 1.0 / 2.6;  // of E = 1 at Poisson's ratio 0.3
    const double size = std::cbrt(total_volume(mesh) / static_cast<double>(mesh.tets.size()));
    const double bound = 2.0 / std::sqrt(greatest_rate(mesh) * shear_modulus) / size;
    const double step = judged_step(mesh);
    EXPECT_LE(step, 1.001 * bound) << "a Rayleigh quotient is no greater than the greatest eigenvalue";
    EXPECT_GT(step, 0.6 * bound);
    const double by_body = 2.0 / std::sqrt(greatest_rate_of_body(mesh).value() * shear_modulus) / size;
    EXPECT_NEAR(step, by_body, 2e-3 * step) << "two programs for one eigenvalue";
  }
}

TEST(StableStep, OfNoBodyThereIsNone) {
  EXPECT_EQ(greatest_rate_of_body(TetMesh{}), 0.0);
}

TEST(StableStep, WhatHasNotConvergedIsNoRate) {
  const TetMesh mesh = build_kuhn_cube(8, 0.3, 1);
  EXPECT_EQ(greatest_rate_of_body(mesh, 0), std::nullopt);
  EXPECT_GT(greatest_rate_of_body(mesh).value(), greatest_rate(mesh));
}

TEST(StableStep, TheFinerMeshSwingsFaster) {
  const TetMesh coarse = build_kuhn_cube(4, 0.0, 1);
  const TetMesh fine = build_kuhn_cube(6, 0.0, 1);
  EXPECT_TRUE(swings_slower(coarse, fine));
  EXPECT_FALSE(swings_slower(fine, coarse));
  EXPECT_FALSE(swings_slower(fine, fine));
}

TEST(StableStep, OfOneTetTheBodysRateIsKnown) {
  // Of all strains of a regular tet stretching it alike, u = x - c, is the stiffest: V 3 (3 lambda + 2 mu)
  // over (V / 4) sum |x - c|^2, where the sum is 1.5 a^2. The others have 16 / a^2.
  const double a = 0.7;
  const double stretch = 3.0 * (3.0 * 1.5 + 2.0) / (0.25 * 1.5 * a * a);
  EXPECT_NEAR(greatest_rate_of_body(regular_tet(a)).value(), stretch, 1e-3 * stretch);
}

TEST(StableStep, IsLongerWithTheBoundaryUntouched) {
  int longer = 0;
  for (const TetMesh& input :
       {build_kuhn_cube(8, 0.3, 1), make_sliver_cube(8, 2), split_tets(build_kuhn_cube(5, 0.2, 1)),
        split_tets(split_tets(build_kuhn_cube(3, 0.2, 4)))}) {
    for (const double ratio : {0.3, 0.5}) {
      SCOPED_TRACE(std::to_string(input.tets.size()) + " " + std::to_string(ratio));
      const TetMesh plain = simplify_for(input, Objective::kShape, ratio);
      const TetMesh stepped = simplify_for(input, Objective::kStableStep, ratio);
      expect_valid_with_boundary_of(stepped, input);
      EXPECT_NEAR(static_cast<double>(stepped.tets.size()), static_cast<double>(plain.tets.size()),
                  0.005 * static_cast<double>(plain.tets.size()) + 12.0);
      EXPECT_LE(greatest_rate(stepped), (1.0 + 1e-9) * greatest_rate(plain));
      const double gain = judged_step(stepped) / judged_step(plain);
      EXPECT_GT(gain, 0.97);
      longer += gain > 1.03 ? 1 : 0;
      EXPECT_EQ(stepped.points, simplify_for(input, Objective::kStableStep, ratio).points)
          << "again, the same";
    }
  }
  EXPECT_GE(longer, 2);  // with a skin as fine as the inside it is the skin that holds
}

TEST(StableStep, WhatIsKeptStays) {
  const TetMesh input = build_kuhn_cube(8, 0.3, 1);
  TetMesh mesh = input;
  RefinedOptions options;
  options.stop.ratio = 0.3;
  options.objective = Objective::kStableStep;
  options.sizing.keep.push_back(
      {.kind = KeptRegion::Kind::kSphere, .center = {0.5, 0.5, 0.5}, .radius = 0.2});
  simplify_refined(mesh, options);
  expect_valid_with_boundary_of(mesh, input);
  std::size_t kept = 0;
  for (const Tet& tet : input.tets) {
    const auto is_near = [&](Index v) { return length(input.points[v] - Vec3{0.5, 0.5, 0.5}) < 0.2; };
    if (!std::any_of(tet.begin(), tet.end(), is_near)) continue;
    ++kept;
    for (const Index v : tet)
      EXPECT_NE(std::find(mesh.points.begin(), mesh.points.end(), input.points[v]), mesh.points.end());
  }
  EXPECT_GT(kept, 10U);
}

TEST(StableStep, MovesOfASkinLetGoOfMoreWithinItsBound) {
  constexpr double kBound = 0.2;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    SCOPED_TRACE(seed);
    GuardedSkin held(make_rough_block(seed), kBound);
    StepLengthener(held.mesh, held.scores, FlipRule{}).run(kStepRounds);
    EXPECT_EQ(held.judged(0.0).points.size(), held.input.points.size());
    GuardedSkin moved(make_rough_block(seed), kBound);
    StepSkinMoves moves(moved.mesh, moved.boundary, moved.report);
    StepLengthener(moved.mesh, moved.scores, FlipRule{}, &moves).run(kStepRounds);
    EXPECT_GT(moved.report.moves, 0U);
    expect_consistent(moved.mesh);
    const TetMesh output = moved.judged(kBound);
    EXPECT_LT(greatest_rate(output), 0.9 * greatest_rate(held.judged(0.0)));
    EXPECT_LT(judge::total_bend(judge::build_boundary(output)),
              1.02 * judge::total_bend(judge::build_boundary(moved.input)));
    EXPECT_NEAR(moved.volume(), total_volume(moved.input), 0.002 * total_volume(moved.input));
  }
}

TEST(StableStep, OfSurfaceIsSeldomShorterThanThatOfEitherKindOfScores) {
  int not_shorter = 0;
  for (const std::uint64_t seed : {1, 2, 3, 4, 5}) {
    const TetMesh input = build_kuhn_cube(8, 0.3, seed);
    const auto step_by = [&](Objective objective) {
      TetMesh mesh = input;
      SurfaceOptions options;
      options.stop.ratio = 0.6;
      options.max_surface_error = 0.02;
      options.objective = objective;
      simplify_surface(mesh, options);
      return judged_step(mesh);
    };
    const double stepped = step_by(Objective::kStableStep);
    const double longest = std::max(step_by(Objective::kShape), step_by(Objective::kQuality));
    EXPECT_GE(stepped, 0.95 * longest) << seed;
    if (stepped >= longest) ++not_shorter;
  }
  EXPECT_GE(not_shorter, 4);
}

}  // namespace
}  // namespace palpate::simplify

// palpate.refined and palpate.surface with wanted sizes: do the edges follow them, and what does it cost?
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/judge/mesh/judge.h"
#include "core/judge/surface/surface.h"
#include "core/mesh/shapes/shapes.h"
#include "core/mesh/topology.h"
#include "core/simplify/refined/refined.h"
#include "core/simplify/surface/surface.h"
#include "tests/support/edge_spread.h"
#include "tests/support/refined_checks.h"

namespace palpate::simplify {
namespace {

using namespace palpate::testing_support;  // NOLINT(google-build-using-namespace)

constexpr std::size_t kSlabs = 4;

const TetMesh& cube() {
  static const TetMesh mesh = build_kuhn_cube(14, 0.15, 4);
  return mesh;
}

/// Three times as long at x = 1 as at x = 0.
double wanted_at(double x) {
  return (1.0 + 2.0 * x) / 3.0;
}

std::shared_ptr<const SizeGrid> linear_grid() {
  std::vector<double> sizes;
  for (const Vec3& p : cube().points) sizes.push_back(wanted_at(p.x));
  return make_size_grid(cube(), sizes);
}

/// Mean of length / wanted length over the edges in each slab of x, over the mean of all.
std::array<double, kSlabs> slab_ratios(const TetMesh& mesh) {
  std::array<double, kSlabs> sum{};
  std::array<double, kSlabs> count{};
  double whole = 0.0;
  double edges = 0.0;
  for (const auto& [a, b] : build_edges(mesh)) {
    const double x = 0.5 * (mesh.points[a].x + mesh.points[b].x);
    const double ratio = length(mesh.points[b] - mesh.points[a]) / wanted_at(x);
    const auto slab = std::min(kSlabs - 1, static_cast<std::size_t>(x * kSlabs));
    sum[slab] += ratio;
    count[slab] += 1.0;
    whole += ratio;
    edges += 1.0;
  }
  std::array<double, kSlabs> mean{};
  for (std::size_t k = 0; k < kSlabs; ++k) mean[k] = sum[k] / count[k] / (whole / edges);
  return mean;
}

double worst_factor(const std::array<double, kSlabs>& ratios) {
  double worst = 1.0;
  for (const double r : ratios) worst = std::max({worst, r, 1.0 / r});
  return worst;
}

/// Of shape alone: q holds volumes against their mean, which a graded mesh is to depart from.
double mean_ratio(const TetMesh& mesh) {
  return judge::measure_quality(mesh).mean_ratio.mean;
}

TetMesh surfaced(const std::shared_ptr<const SizeGrid>& sizes, Objective objective = Objective::kShape) {
  TetMesh mesh = cube();
  SurfaceOptions options;
  options.objective = objective;
  options.stop.ratio = 0.85;
  options.max_surface_error = 1e-6;  // the sides are flat
  options.sizing.sizes = sizes;
  simplify_surface(mesh, options);
  return mesh;
}

/// A linear field in a box: edges follow within a fifth, slab by slab, skin and inside; without a field they
/// are off by more than a half, so the check would see it. `one_size`: the mean ratio of a mesh of one size
/// whose skin is not evened out.
void expect_edges_follow(Objective objective, double one_size) {
  const TetMesh graded = surfaced(linear_grid(), objective);
  const TetMesh even = surfaced(nullptr, Objective::kQuality);  // by shapes its skin would be evened out
  EXPECT_LE(worst_factor(slab_ratios(graded)), 1.2);
  EXPECT_GE(worst_factor(slab_ratios(even)), 1.5);
  EXPECT_NEAR(static_cast<double>(graded.tets.size()), 0.15 * static_cast<double>(cube().tets.size()),
              0.005 * static_cast<double>(cube().tets.size()));
  // The same guarantees as ever.
  EXPECT_TRUE(judge::check_validity(graded).is_valid());
  const auto distance =
      judge::measure_surface_distance(judge::build_boundary(graded), judge::build_boundary(cube()));
  EXPECT_LE(distance.upper(), 1e-6);
  // Its shapes are at most 0.02 worse than those of one size.
  EXPECT_GE(mean_ratio(graded), one_size - 0.02);
}

TEST(GradedSizes, EdgesFollowALinearFieldInABox) {
  expect_edges_follow(Objective::kShape, 0.8873);
  expect_edges_follow(Objective::kQuality, 0.8605);
}

TEST(GradedSizes, ACoarsenedSkinIsEvenedOutOverThem) {
  const auto spread_by = [](Objective objective) {
    return spread_of_edges(surfaced(linear_grid(), objective), [](const Vec3& x) { return wanted_at(x.x); });
  };
  const double evened = spread_by(Objective::kShape);
  EXPECT_LT(evened, 0.25);  // 0.35 where no length is evened out
  EXPECT_LT(evened, 0.9 * spread_by(Objective::kQuality));
}

TEST(GradedSizes, RefinedFollowsInsideAndKeepsTheBoundary) {
  TetMesh graded = cube();
  RefinedOptions options;
  options.stop.ratio = 0.6;
  TetMesh even = cube();
  simplify_refined(even, options);
  options.sizing.sizes = linear_grid();
  simplify_refined(graded, options);
  expect_valid_with_boundary_of(graded, cube());
  const auto far_over_near = [](const TetMesh& mesh) {
    std::array<double, 2> sum{};
    std::array<double, 2> count{};
    const std::vector<std::uint8_t> skin = build_boundary_vertex_flags(mesh);
    for (const auto& [a, b] : build_edges(mesh)) {
      if (skin[a] != 0 || skin[b] != 0) continue;
      const double x = 0.5 * (mesh.points[a].x + mesh.points[b].x);
      if (x > 0.3 && x < 0.7) continue;
      sum[x > 0.5 ? 1 : 0] += length(mesh.points[b] - mesh.points[a]);
      count[x > 0.5 ? 1 : 0] += 1.0;
    }
    return sum[1] / count[1] / (sum[0] / count[0]);
  };
  EXPECT_LT(far_over_near(even), 1.1);
  EXPECT_GT(far_over_near(graded),
            1.4);  // wanted: wanted_at(0.8) / wanted_at(0.2) = 1.86; the skin holds some
  // A skin that stays fine beside an inside that is far coarser costs shapes: 0.08 at most.
  EXPECT_GE(mean_ratio(graded), mean_ratio(even) - 0.08);
}

TEST(GradedSizes, TheSameSizesGiveTheSameBytesAndEqualOnesThoseOfNone) {
  const TetMesh once = surfaced(linear_grid());
  const TetMesh again = surfaced(linear_grid());
  EXPECT_EQ(once.points, again.points);
  EXPECT_EQ(once.tets, again.tets);
  const TetMesh none = surfaced(nullptr);
  const TetMesh equal = surfaced(make_size_grid(cube(), std::vector<double>(cube().points.size(), 0.7)));
  EXPECT_EQ(none.points, equal.points);
  EXPECT_EQ(none.tets, equal.tets);
  EXPECT_NE(none.points, once.points);
}

}  // namespace
}  // namespace palpate::simplify

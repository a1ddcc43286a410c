// Sharp edges kept by angle: the operations on lines, and whole runs against closed forms and the judge.
#include "core/simplify/skin_guard/feature_lines.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <set>

#include "core/base/error.h"
#include "core/judge/mesh/judge.h"
#include "core/judge/surface/feature_distance.h"
#include "core/judge/surface/surface.h"
#include "core/mesh/shapes/shapes.h"
#include "core/simplify/skin_guard/guarded_boundary.h"
#include "core/simplify/surface/surface.h"
#include "tests/support/small_meshes.h"

namespace palpate::simplify {
namespace {

using namespace palpate::testing_support;  // NOLINT(google-build-using-namespace)

constexpr double kFeatureDeg = 40.0;
constexpr double kSharpDeg = 60.0;  ///< what counts as sharp in an output whose sharp edges are all of 90

/// The prism over an L of three n x n squares, 2 n high.
TetMesh make_l_prism(int n) {
  std::vector<Cell> cells;
  for (int x = 0; x < 2 * n; ++x) {
    for (int y = 0; y < 2 * n; ++y) {
      for (int z = 0; z < 2 * n; ++z) {
        if (x < n || y < n) cells.push_back({x, y, z});
      }
    }
  }
  return make_kuhn_cells(cells);
}

constexpr int kRimHalf = 6;  ///< the rim is a regular polygon of 8 times as many corners
constexpr int kCylinderHigh = 8;

/// A cylinder of radius 1 from z = 0 to z = 1.5: squares of a block become circles, at equal angles.
TetMesh make_cylinder() {
  TetMesh mesh = make_kuhn_block(2 * kRimHalf, 2 * kRimHalf, kCylinderHigh);
  for (Vec3& p : mesh.points) {
    const double x = p.x / kRimHalf - 1.0;
    const double y = p.y / kRimHalf - 1.0;
    const double radius = std::max(std::fabs(x), std::fabs(y));
    if (radius > 0.0) {
      const bool is_wide = std::fabs(x) >= std::fabs(y);
      const double turn = 0.25 * std::numbers::pi * (is_wide ? y / x : x / y);
      const double far = radius * std::cos(turn) * (is_wide ? std::copysign(1.0, x) : std::copysign(1.0, y));
      const double side = radius * std::sin(turn) * (is_wide ? std::copysign(1.0, x) : std::copysign(1.0, y));
      p.x = is_wide ? far : side;
      p.y = is_wide ? side : far;
    } else {
      p.x = p.y = 0.0;
    }
    p.z *= 1.5 / kCylinderHigh;
  }
  return mesh;
}

struct Kept {
  TetMesh mesh;
  SurfaceRunReport report;
};

Kept simplified(const TetMesh& input, double bound, double ratio, double feature_deg, bool sparing = true) {
  Kept kept{input, {}};
  SurfaceOptions options;
  options.sparing = sparing;
  options.max_surface_error = bound;
  options.stop.ratio = ratio;
  options.feature_deg = feature_deg;
  kept.report = simplify_surface(kept.mesh, options);
  EXPECT_TRUE(judge::check_validity(kept.mesh).is_valid());
  const SurfaceMesh skin = judge::build_boundary(kept.mesh);
  EXPECT_EQ(judge::count_self_intersections(skin), 0U);
  const judge::SurfaceDistance distance = judge::measure_surface_distance(skin, judge::build_boundary(input));
  EXPECT_LE(distance.upper(), bound + 1e-7 * distance.diagonal);
  return kept;
}

std::vector<judge::EdgeEnds> sharp_edges(const TetMesh& mesh) {
  return judge::list_sharp_edges(judge::build_boundary(mesh), kSharpDeg);
}

double total_length(const std::vector<judge::EdgeEnds>& edges) {
  double sum = 0.0;
  for (const auto& [a, b] : edges) sum += length(b - a);
  return sum;
}

/// Whether the sharp edges of both are the same point set and all of `corners` are vertices still, to the
/// bit: coordinates here are whole numbers, so distances of 0 and sums of lengths are exact.
bool keeps_straight_edges(const TetMesh& output, const TetMesh& input, const std::vector<Vec3>& corners) {
  const auto before = sharp_edges(input);
  const auto after = sharp_edges(output);
  const bool is_same = judge::measure_edge_distance(before, after).lower == 0.0 &&
                       judge::measure_edge_distance(after, before).lower == 0.0 &&
                       total_length(before) == total_length(after);
  const auto is_there = [&](const Vec3& corner) {
    return std::find(output.points.begin(), output.points.end(), corner) != output.points.end();
  };
  return is_same && std::all_of(corners.begin(), corners.end(), is_there);
}

std::vector<Vec3> box_corners(double size) {
  std::vector<Vec3> corners;
  for (const double x : {0.0, size}) {
    for (const double y : {0.0, size}) {
      for (const double z : {0.0, size}) corners.push_back({x, y, z});
    }
  }
  return corners;
}

TEST(FeatureLines, ACubesTwelveEdgesAndEightCornersSurviveToTheBit) {
  const TetMesh cube = make_kuhn_block(10, 10, 10);
  ASSERT_EQ(total_length(sharp_edges(cube)), 120.0);
  for (const double bound : {0.0, 0.3, 1.5}) {
    SCOPED_TRACE(bound);
    const Kept kept = simplified(cube, bound, 0.985, kFeatureDeg);
    EXPECT_TRUE(keeps_straight_edges(kept.mesh, cube, box_corners(10.0)));
    EXPECT_EQ(kept.report.feature_edges_in, 120U);
    EXPECT_EQ(kept.report.feature_corners, 8U);
    EXPECT_LE(kept.report.feature_edges_out, 40U);  // 12 would be the least
    EXPECT_EQ(kept.report.feature_edges_out, sharp_edges(kept.mesh).size());
    EXPECT_LE(kept.mesh.tets.size(), cube.tets.size() / 50);
    // Without the option the same bound cuts them; one of 0 keeps them but for rounding.
    if (bound == 0.0) continue;
    EXPECT_FALSE(keeps_straight_edges(simplified(cube, bound, 0.985, 0.0).mesh, cube, box_corners(10.0)));
  }
}

TEST(FeatureLines, AnLPrismKeepsItsEdgesTheInwardOneToo) {
  const int n = 4;
  const TetMesh prism = make_l_prism(n);
  const double edge = 2.0 * n;
  std::vector<Vec3> corners;
  for (const double z : {0.0, edge}) {
    for (const Vec3& p : {Vec3{0, 0, z}, Vec3{edge, 0, z}, Vec3{edge, n, z}, Vec3{n, n, z}, Vec3{n, edge, z},
                          Vec3{0, edge, z}})
      corners.push_back(p);
  }
  ASSERT_EQ(total_length(sharp_edges(prism)), 6 * edge + 2 * 4 * edge);  // upright; around the L, twice
  const Kept kept = simplified(prism, 0.6, 0.97, kFeatureDeg);
  EXPECT_TRUE(keeps_straight_edges(kept.mesh, prism, corners));
  EXPECT_EQ(kept.report.feature_corners, 12U);
  EXPECT_FALSE(keeps_straight_edges(simplified(prism, 0.6, 0.97, 0.0).mesh, prism, corners));
}

/// The greatest distance between the sharp edges of a mesh and the two rims of the cylinder, both ways, by
/// samples of the circles and of the edges.
double distance_from_rims(const TetMesh& mesh) {
  const auto edges = sharp_edges(mesh);
  double farthest = 0.0;
  for (const auto& [a, b] : edges) {
    for (int k = 0; k <= 20; ++k) {
      const Vec3 p = a + (k / 20.0) * (b - a);
      const double height = std::min(std::fabs(p.z), std::fabs(p.z - 1.5));
      farthest = std::max(farthest, std::hypot(std::hypot(p.x, p.y) - 1.0, height));
    }
  }
  for (int k = 0; k < 720; ++k) {
    const double turn = 2.0 * std::numbers::pi * k / 720.0;
    for (const double z : {0.0, 1.5}) {
      const Vec3 p{std::cos(turn), std::sin(turn), z};
      double nearest = 1e300;
      for (const auto& [a, b] : edges)
        nearest = std::min(nearest, std::sqrt(distance_sq_to_segment(p, a, b)));
      farthest = std::max(farthest, nearest);
    }
  }
  return farthest;
}

TEST(FeatureLines, ACylindersRimsStayCirclesWithinTheBound) {
  const TetMesh cylinder = make_cylinder();
  ASSERT_TRUE(judge::check_validity(cylinder).is_valid());
  const double sagitta = 1.0 - std::cos(std::numbers::pi / (8.0 * kRimHalf));  // the polygon's own
  ASSERT_NEAR(distance_from_rims(cylinder), sagitta, 1e-9);
  for (const double bound : {0.01, 0.03, 0.06}) {
    SCOPED_TRACE(bound);
    const Kept kept = simplified(cylinder, bound, 0.96, kFeatureDeg, false);
    EXPECT_EQ(kept.report.feature_edges_in, 16U * kRimHalf);
    EXPECT_EQ(kept.report.feature_corners, 0U);
    EXPECT_LE(kept.report.feature_edges_out, 8U * kRimHalf);
    EXPECT_GE(kept.report.feature_edges_out, 6U);  // two rings of three
    EXPECT_EQ(sharp_edges(kept.mesh).size(), kept.report.feature_edges_out);
    EXPECT_LE(distance_from_rims(kept.mesh), bound + sagitta);
    const judge::FeatureDistance found = judge::measure_feature_distance(
        judge::build_boundary(cylinder), judge::build_boundary(kept.mesh), kFeatureDeg);
    EXPECT_EQ(found.input_edges, 16U * kRimHalf);
    EXPECT_LE(found.kept.lower, bound);
    // Without the option a rim goes, and the same check rejects it. A tight bound on the skin keeps it as
    // well.
    if (bound < 0.02) continue;
    const Kept cut = simplified(cylinder, bound, 0.96, 0.0, false);
    EXPECT_GT(distance_from_rims(cut.mesh), bound + sagitta);
  }
}

TEST(FeatureLines, ABodyWithoutSharpEdgesGetsTheSameBytes) {
  TetMesh ball = make_kuhn_block(8, 8, 8);
  for (Vec3& p : ball.points) {  // sides are blown up: no edge is sharper than 90 degrees
    const Vec3 q = 0.25 * (p - Vec3{4, 4, 4});
    p = (1.0 + 0.15 * (3.0 - length_sq(q))) * q;
  }
  const Kept without = simplified(ball, 0.05, 0.8, 0.0);
  const Kept with = simplified(ball, 0.05, 0.8, 100.0);
  EXPECT_EQ(with.report.feature_edges_in, 0U);
  EXPECT_GT(without.report.surface.collapses, 0U);
  EXPECT_EQ(without.mesh, with.mesh);
  EXPECT_EQ(simplified(ball, 0.05, 0.8, 30.0).mesh, simplified(ball, 0.05, 0.8, 30.0).mesh);
  EXPECT_NE(without.mesh, simplified(ball, 0.05, 0.8, 30.0).mesh);
}

TEST(FeatureLines, RefusesAnglesThatAreNone) {
  TetMesh mesh = make_kuhn_block(2, 2, 2);
  for (const double degrees : {-1.0, 180.0, std::nan("")}) {
    SurfaceOptions options;
    options.feature_deg = degrees;
    EXPECT_THROW(simplify_surface(mesh, options), InputError) << degrees;
  }
}

/// The rims of the cylinder as lines, with the numbers of one rim's vertices in order.
struct Rims {
  WorkingMesh mesh = build_working_mesh(make_cylinder(), SizingField());
  FeatureLines lines;
  std::vector<Index> ring;

  explicit Rims(double limit) {
    const SurfaceMesh skin = judge::build_boundary({mesh.points, mesh.tets});
    lines = FeatureLines(mesh, skin.triangles, kFeatureDeg, limit);
    for (Index v = 0; v < mesh.points.size(); ++v) {
      if (mesh.points[v].z == 0.0 && lines.rank(v) == FeatureRank::kOnLine) ring.push_back(v);
    }
    const auto turn = [&](Index v) { return std::atan2(mesh.points[v].y, mesh.points[v].x); };
    std::sort(ring.begin(), ring.end(), [&](Index a, Index b) { return turn(a) < turn(b); });
  }

  /// Takes vertices out of the ring one after another, every second one, as long as it is permitted.
  std::size_t thin_out() {
    std::size_t taken = 0;
    for (bool goes_on = true; goes_on;) {
      goes_on = false;
      for (std::size_t i = 0; i + 1 < ring.size(); ++i) {
        const Vec3 to = mesh.points[ring[i + 1]];
        if (!lines.permits_collapse(mesh, ring[i], ring[i + 1], to)) continue;
        lines.collapse(ring[i], ring[i + 1]);
        ring.erase(ring.begin() + static_cast<std::ptrdiff_t>(i));
        ++taken;
        goes_on = true;
      }
    }
    return taken;
  }
};

TEST(FeatureLines, AChordIsPermittedUpToTheLimitAndErrorsDoNotAddUp) {
  // A chord over k edges of the ring is 1 - cos(k pi / n) from its middle, n = 48, less what the polygon's
  // own corner there lacks.
  const double quarter = std::numbers::pi / (8.0 * kRimHalf);
  for (const int steps : {2, 4, 8}) {
    SCOPED_TRACE(steps);
    const double needed = 1.0 - std::cos(steps * quarter);
    const double next = 1.0 - std::cos((steps + 1) * quarter);
    Rims rims(0.5 * (needed + next));
    ASSERT_EQ(rims.ring.size(), 8U * kRimHalf);
    EXPECT_GT(rims.thin_out(), 0U);
    double longest = 0.0;
    for (std::size_t i = 0; i < rims.ring.size(); ++i) {
      const Vec3 a = rims.mesh.points[rims.ring[i]];
      const Vec3 b = rims.mesh.points[rims.ring[(i + 1) % rims.ring.size()]];
      longest = std::max(longest, length(b - a));
    }
    EXPECT_NEAR(longest, 2.0 * std::sin(steps * quarter), 1e-12);
  }
}

TEST(FeatureLines, ARingKeepsThreeEdgesWhateverTheLimit) {
  Rims rims(100.0);
  rims.thin_out();
  EXPECT_EQ(rims.ring.size(), 3U);
  EXPECT_EQ(rims.lines.size(), 8U * kRimHalf + 3U);
}

TEST(FeatureLines, APlaceOffTheLineIsRefusedThoughTheLineWouldBeCovered) {
  // One direction alone would let a spike of the line stick out: all of the input's line is near to it.
  Rims rims(0.05);
  const Index gone = rims.ring[4];
  const Index survivor = rims.ring[5];
  const Vec3 there = rims.mesh.points[survivor];
  EXPECT_TRUE(rims.lines.permits_collapse(rims.mesh, gone, survivor, there + Vec3{0, 0, 0.049}));
  EXPECT_FALSE(rims.lines.permits_collapse(rims.mesh, gone, survivor, there + Vec3{0, 0, 0.051}));
  EXPECT_FALSE(rims.lines.permits_collapse(rims.mesh, gone, survivor, there + Vec3{0, 0, 1.5}));
}

TEST(FeatureLines, CornersAreEndsMeetingsAndTurns) {
  const WorkingMesh mesh = build_working_mesh(make_kuhn_block(4, 4, 4), SizingField());
  const GuardedBoundary boundary(mesh, 0.1, kFeatureDeg);
  std::size_t corners = 0;
  for (Index v = 0; v < mesh.points.size(); ++v) {
    const Vec3& p = mesh.points[v];
    int at_side = 0;
    for (const double x : {p.x, p.y, p.z}) at_side += x == 0.0 || x == 4.0 ? 1 : 0;
    const FeatureRank expected = at_side == 3   ? FeatureRank::kCorner
                                 : at_side == 2 ? FeatureRank::kOnLine
                                                : FeatureRank::kNone;
    EXPECT_EQ(boundary.lines().rank(v), expected);
    if (expected == FeatureRank::kCorner) ++corners;
  }
  EXPECT_EQ(corners, 8U);
  EXPECT_EQ(boundary.lines().corners(), 8U);
  EXPECT_EQ(boundary.lines().size(), 48U);
  EXPECT_TRUE(GuardedBoundary(mesh, 0.1).lines().is_empty());
}

TEST(LineCover, SegmentsThatGoOnFromOneAnotherCoverAtNoDistance) {
  const std::vector<SegmentEnds> by{{Vec3{0, 0, 0}, Vec3{1, 0, 0}}, {Vec3{1, 0, 0}, Vec3{3, 0, 0}}};
  std::vector<Index> used;
  LineCover exact(1e-14);
  EXPECT_TRUE(exact.is_covered({Vec3{0.3, 0, 0}, Vec3{2.9, 0, 0}}, by, used));
  EXPECT_EQ(used.size(), 2U);
  EXPECT_FALSE(exact.is_covered({Vec3{0.3, 0, 0}, Vec3{3.1, 0, 0}}, by, used));
  // A gap in the middle is seen though both ends are covered.
  const std::vector<SegmentEnds> apart{{Vec3{0, 0, 0}, Vec3{1, 0, 0}}, {Vec3{2, 0, 0}, Vec3{3, 0, 0}}};
  const SegmentEnds whole{Vec3{0, 0, 0}, Vec3{3, 0, 0}};
  EXPECT_FALSE(LineCover(0.49).is_covered(whole, apart, used));
  EXPECT_TRUE(LineCover(0.51).is_covered(whole, apart, used));
}

TEST(LineCover, NeverSaysYesAgainstTheJudgeAndSeldomNo) {
  std::size_t yes = 0;
  std::size_t too_careful = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    SplitMix64 random(seed);
    const auto point = [&] { return Vec3{random.uniform(), random.uniform(), random.uniform()}; };
    const SegmentEnds one{point(), point()};
    std::vector<SegmentEnds> others;
    for (int i = 0; i < 12; ++i) {
      const Vec3 from = point();
      others.push_back({from, from + 0.4 * (point() - Vec3{0.5, 0.5, 0.5})});
    }
    const judge::EdgeDistance exact = judge::measure_edge_distance({one}, others);
    std::vector<Index> used;
    for (const double factor : {0.8, 0.99, 1.01, 1.2}) {
      const double limit = factor * exact.upper;
      const bool is_covered = LineCover(limit).is_covered(one, others, used);
      EXPECT_TRUE(!is_covered || limit >= exact.lower) << "seed " << seed;
      yes += is_covered ? 1U : 0U;
      too_careful += !is_covered && factor > 1.005 ? 1U : 0U;
    }
  }
  EXPECT_GT(yes, 300U);
  EXPECT_EQ(too_careful, 0U);
}

}  // namespace
}  // namespace palpate::simplify

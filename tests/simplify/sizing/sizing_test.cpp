#include "core/simplify/sizing/sizing.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/mesh/shapes/shapes.h"
#include "core/mesh/topology.h"
#include "tests/support/small_meshes.h"

namespace palpate::simplify {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

KeptRegion sphere(const Vec3& center, double radius) {
  return {.kind = KeptRegion::Kind::kSphere, .center = center, .radius = radius};
}

KeptRegion half_space(const Vec3& normal, double offset) {
  return {.kind = KeptRegion::Kind::kHalfSpace, .normal = normal, .offset = offset};
}

KeptRegion patch(const Vec3& center, double radius, double depth) {
  return {.kind = KeptRegion::Kind::kSurfacePatch, .center = center, .radius = radius, .depth = depth};
}

SizingOptions options_of(std::vector<KeptRegion> keep, double near_size = 0.5, double reach = 0.0) {
  return {std::move(keep), near_size, reach};
}

Vec3 random_point(SplitMix64& random, double low, double high) {
  const auto one = [&] { return low + (high - low) * random.uniform(); };
  const double x = one();
  const double y = one();
  return {x, y, one()};
}

/// Grid points of a triangle, `n` steps a side.
std::vector<Vec3> samples(const std::array<Vec3, 3>& t, int n) {
  std::vector<Vec3> points;
  for (int i = 0; i <= n; ++i) {
    for (int j = 0; j + i <= n; ++j) {
      const double a = static_cast<double>(i) / n;
      const double b = static_cast<double>(j) / n;
      points.push_back((1.0 - a - b) * t[0] + a * t[1] + b * t[2]);
    }
  }
  return points;
}

double longest_edge(std::span<const Vec3> corners) {
  double longest = 0.0;
  for (const Vec3& a : corners) {
    for (const Vec3& b : corners) longest = std::max(longest, length(a - b));
  }
  return longest;
}

TEST(Sizing, EmptyFieldKeepsNothingAndChangesNoSize) {
  const TetMesh mesh = build_kuhn_cube(2, 0.0, 0);
  for (const SizingField& field : {SizingField(), SizingField(SizingOptions{}, mesh)}) {
    EXPECT_TRUE(field.is_empty());
    EXPECT_EQ(field.distance({0.3, 0.2, 0.1}), kInfinity);
    EXPECT_EQ(field.relative_size({0.3, 0.2, 0.1}), 1.0);
    EXPECT_TRUE(build_kept_tets(field, mesh).empty());
    EXPECT_TRUE(build_kept_vertices({}, mesh).empty());
  }
}

TEST(Sizing, ClosedFormsOfDistanceAndSize) {
  const TetMesh mesh = build_kuhn_cube(2, 0.0, 0);
  const SizingField ball(options_of({sphere({0.5, 0.5, 0.5}, 0.25)}, 0.4, 0.5), mesh);
  EXPECT_EQ(ball.distance({0.5, 0.5, 0.75}), 0.0);
  EXPECT_EQ(ball.distance({0.5, 0.5, 1.25}), 0.5);
  EXPECT_EQ(ball.relative_size({0.5, 0.5, 0.6}), 0.4);
  EXPECT_DOUBLE_EQ(ball.relative_size({0.5, 0.5, 1.0}), 0.7);  // halfway: the mean of 0.4 and 1
  EXPECT_DOUBLE_EQ(ball.relative_size({0.5, 0.5, 0.875}), 0.4 + 0.6 * (3.0 / 16.0 - 2.0 / 64.0));
  EXPECT_EQ(ball.relative_size({0.5, 0.5, 1.25}), 1.0);
  EXPECT_EQ(ball.relative_size({9.0, 0.5, 1.25}), 1.0);

  // Three times the normal and the offset is the same half-space.
  for (const double factor : {1.0, 3.0}) {
    const SizingField half(options_of({half_space({0, 0, -factor}, -0.75 * factor)}), mesh);
    EXPECT_EQ(half.distance({0.3, 0.1, 0.75}), 0.0);
    EXPECT_EQ(half.distance({0.3, 0.1, 0.25}), 0.5);
    EXPECT_DOUBLE_EQ(half.reach(), 0.25 * std::sqrt(3.0));
    EXPECT_EQ(half.near_size(), 0.5);
  }

  const SizingField both(options_of({sphere({0, 0, 0}, 1.0), half_space({1, 0, 0}, -3.0)}, 0.5, 4.0), mesh);
  EXPECT_EQ(both.distance({-1.5, 0, 0}), 0.5);
  EXPECT_EQ(both.distance({-2.75, 0, 0}), 0.25);
  EXPECT_EQ(both.distance({0.2, 0, 0}), 0.0);

  // A corner tet's patch: its whole boundary.
  const TetMesh tet = testing_support::make_corner_tet();
  const SizingField skin(options_of({patch({0, 0, 0}, 0.5, 0.0)}), tet);
  EXPECT_EQ(skin.distance({0.2, 0.2, -0.5}), 0.5);
  EXPECT_EQ(skin.distance({-3, 0, 0}), 3.0);
  EXPECT_EQ(skin.distance({0, 0, 0}), 0.0);
  const SizingField shell(options_of({patch({0, 0, 0}, 0.5, 0.25)}), tet);
  EXPECT_EQ(shell.distance({0.2, 0.2, -0.5}), 0.25);
  EXPECT_EQ(shell.distance({0.2, 0.2, -0.2}), 0.0);
}

TEST(Sizing, LipschitzAndWithinItsBounds) {
  const TetMesh mesh = build_kuhn_cube(6, 0.3, 2);
  const SizingField field(
      options_of({sphere({0.2, 0.3, 0.4}, 0.1), half_space({0, 1, 1}, 0.3), patch({1, 1, 1}, 0.35, 0.05)},
                 0.3, 0.4),
      mesh);
  const double constant = 1.5 * (1.0 - field.near_size()) / field.reach();
  SplitMix64 random(11);
  for (int i = 0; i < 20000; ++i) {
    const Vec3 x = random_point(random, -0.5, 1.5);
    const Vec3 y = x + random_point(random, -0.05, 0.05);
    const double apart = length(x - y);
    const double rounding = 1e-14;  // some ulps of values of order 1
    const double size = field.relative_size(x);
    EXPECT_LE(std::fabs(field.distance(x) - field.distance(y)), apart + rounding);
    EXPECT_LE(std::fabs(size - field.relative_size(y)), constant * apart + rounding);
    EXPECT_GE(size, field.near_size());
    EXPECT_LE(size, 1.0);
    EXPECT_EQ(size == 1.0, field.distance(x) >= field.reach()) << field.distance(x);
  }
}

TEST(Sizing, TheSizeHasNoKinkAtTheBorderAndAtTheReach) {
  const SizingField field(options_of({half_space({1, 0, 0}, 0.0)}, 0.5, 1.0), build_kuhn_cube(1, 0.0, 0));
  const double h = 1e-4;  // the slope there is 6 t (1 - t) / 2, so a step of h changes the size by 1.5 h^2
  EXPECT_LE(field.relative_size({h, 0, 0}) - field.relative_size({0, 0, 0}), 1.5 * h * h);
  EXPECT_LE(field.relative_size({1, 0, 0}) - field.relative_size({1 - h, 0, 0}), 1.5 * h * h + 1e-15);
}

TEST(Sizing, PatchDistanceAgainstAllItsFaces) {
  const TetMesh mesh = build_kuhn_cube(9, 0.0, 0);
  const Vec3 center{0.9, 0.4, 1.0};
  const double radius = 0.45;
  std::vector<Triangle> faces;
  for (const Triangle& f : build_boundary(mesh)) {
    for (const Index v : f) {
      if (length(mesh.points[v] - center) <= radius) {
        faces.push_back(f);
        break;
      }
    }
  }
  ASSERT_GT(faces.size(), 50U);
  const SizingField field(options_of({patch(center, radius, 0.0)}), mesh);
  SplitMix64 random(5);
  for (int i = 0; i < 300; ++i) {
    const Vec3 x = random_point(random, -0.3, 1.6);
    double least = kInfinity;
    double sampled = kInfinity;
    const int steps = 12;
    double spacing = 0.0;
    for (const Triangle& f : faces) {
      const std::array<Vec3, 3> t{mesh.points[f[0]], mesh.points[f[1]], mesh.points[f[2]]};
      least = std::min(least, std::sqrt(distance_sq_to_triangle(x, t[0], t[1], t[2])));
      for (const Vec3& p : samples(t, steps)) sampled = std::min(sampled, length(x - p));
      spacing = std::max(spacing, longest_edge(t) / steps);
    }
    EXPECT_EQ(field.distance(x), least);
    EXPECT_LE(least, sampled + 1e-15);
    EXPECT_GE(least, sampled - spacing);
  }
}

TEST(Sizing, TheTreeGivesUpAtTheBound) {
  const TetMesh tet = testing_support::make_corner_tet();
  const std::vector<Triangle> faces = build_boundary(tet);
  const TriangleTree tree(tet.points, faces);
  EXPECT_EQ(tree.distance({0.2, 0.2, -0.5}), 0.5);
  EXPECT_EQ(tree.distance({0.2, 0.2, -0.5}, 0.75), 0.5);
  EXPECT_EQ(tree.distance({0.2, 0.2, -0.5}, 0.25), 0.25);
  EXPECT_THROW(TriangleTree(tet.points, {}), InputError);
}

TEST(Sizing, SegmentsAndTrianglesOfRandomShapesAgainstSamples) {
  SplitMix64 random(21);
  for (int i = 0; i < 2000; ++i) {
    const auto point = [&] { return random_point(random, 0.0, 1.0); };
    const std::array<Vec3, 2> p{point(), point()};
    // Every tenth segment is a point; lying apart by 1.5 or so, they never cross.
    const Vec3 q0 = point() + Vec3{1.5, 0, 0};
    const std::array<Vec3, 2> q{q0, i % 10 == 0 ? q0 : point() + Vec3{1.5, 0, 0}};
    const int steps = 40;
    double sampled = kInfinity;
    for (int a = 0; a <= steps; ++a) {
      const double s = static_cast<double>(a) / steps;
      sampled = std::min(sampled, distance_sq_to_segment(p[0] + s * (p[1] - p[0]), q[0], q[1]));
    }
    const double found = std::sqrt(distance_sq_of_segments(p[0], p[1], q[0], q[1]));
    EXPECT_LE(found, std::sqrt(sampled) + 1e-14);
    EXPECT_GE(found, std::sqrt(sampled) - length(p[1] - p[0]) / steps);
  }
}

TEST(Sizing, DistanceOfTetAndTriangleAgainstSamples) {
  SplitMix64 random(8);
  for (int i = 0; i < 200; ++i) {
    const auto point = [&](double x) { return random_point(random, 0.0, 1.0) + Vec3{x, 0, 0}; };
    const std::array<Vec3, 4> tet{point(0), point(0), point(0), point(0)};
    const std::array<Vec3, 3> triangle{point(1.01), point(1.01), point(1.01)};
    const int steps = 24;
    double sampled = kInfinity;
    for (const auto& [a, b, c] : kTetFaces) {
      for (const Vec3& p : samples({tet[a], tet[b], tet[c]}, steps))
        sampled = std::min(sampled, distance_sq_to_triangle(p, triangle[0], triangle[1], triangle[2]));
    }
    const double found = std::sqrt(distance_sq_of_tet_and_triangle(tet, triangle));
    EXPECT_LE(found, std::sqrt(sampled) + 1e-14);
    EXPECT_GE(found, std::sqrt(sampled) - longest_edge(tet) / steps);
  }
}

/// The kept tets of `mesh` by number.
std::vector<Index> kept_numbers(const std::vector<KeptRegion>& keep, const TetMesh& mesh) {
  const std::vector<std::uint8_t> flags = build_kept_tets(SizingField(options_of(keep), mesh), mesh);
  std::vector<Index> kept;
  for (Index t = 0; t < flags.size(); ++t) {
    if (flags[t] != 0) kept.push_back(t);
  }
  return kept;
}

TEST(Sizing, KeptTetsByHand) {
  // Two tets that share a face at z = 0: tet 0 above it, tet 1 below.
  const TetMesh two = testing_support::make_two_tets();
  using Kept = std::vector<Index>;
  EXPECT_EQ(kept_numbers({half_space({0, 0, 1}, -0.125)}, two), (Kept{1}));
  EXPECT_EQ(kept_numbers({half_space({0, 0, -1}, -0.125)}, two), (Kept{0}));
  EXPECT_EQ(kept_numbers({half_space({0, 0, 1}, 0.0)}, two), (Kept{0, 1}));  // what touches, meets
  EXPECT_EQ(kept_numbers({half_space({0, 0, 1}, -1.5)}, two), (Kept{}));
  // Inside tet 0, near no face and no vertex of it.
  EXPECT_EQ(kept_numbers({sphere({0.25, 0.25, 0.25}, 1e-3)}, two), (Kept{0}));
  EXPECT_EQ(kept_numbers({sphere({0.25, 0.25, 0.25}, 0.249)}, two), (Kept{0}));
  EXPECT_EQ(kept_numbers({sphere({0.25, 0.25, 0.25}, 0.25)}, two), (Kept{0, 1}));
  // Against the slanted face of tet 0, away from its vertices and edges.
  const double third = 1.0 / 3.0;
  const double gap = std::sqrt(3.0) * third;
  EXPECT_EQ(kept_numbers({sphere({2 * third, 2 * third, 2 * third}, 0.999 * gap)}, two), (Kept{}));
  EXPECT_EQ(kept_numbers({sphere({2 * third, 2 * third, 2 * third}, 1.001 * gap)}, two), (Kept{0}));
  // A patch of the faces around the upper apex: of tet 0 alone. Tet 1 touches them along the shared edges.
  EXPECT_EQ(kept_numbers({patch({0, 0, 1}, 0.1, 0.0)}, two), (Kept{0, 1}));
}

TEST(Sizing, KeptTetsOfACubeFace) {
  // Layers of tets between z = k/4 and (k+1)/4; the patch is the whole top, at z = 1.
  const TetMesh mesh = build_kuhn_cube(4, 0.0, 0);
  const std::vector<std::uint8_t> flags =
      build_kept_tets(SizingField(options_of({half_space({0, 0, -1}, -0.8)}), mesh), mesh);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    double highest = 0.0;
    for (const Index v : mesh.tets[t]) highest = std::max(highest, mesh.points[v].z);
    EXPECT_EQ(flags[t] != 0, highest == 1.0);
  }
}

TEST(Sizing, KeptTetsOfAPatchAgainstAllPairs) {
  const TetMesh mesh = build_kuhn_cube(6, 0.35, 4);
  const Vec3 center{0.5, 0.5, 1.0};
  for (const double depth : {0.0, 0.11, 0.3}) {
    std::vector<std::array<Vec3, 3>> faces;
    for (const Triangle& f : build_boundary(mesh)) {
      const std::array<Vec3, 3> t{mesh.points[f[0]], mesh.points[f[1]], mesh.points[f[2]]};
      const bool is_in =
          std::any_of(t.begin(), t.end(), [&](const Vec3& p) { return length(p - center) <= 0.3; });
      if (is_in) faces.push_back(t);
    }
    std::vector<Index> expected;
    for (Index t = 0; t < mesh.tets.size(); ++t) {
      std::array<Vec3, 4> tet;
      for (std::size_t i = 0; i < 4; ++i) tet[i] = mesh.points[mesh.tets[t][i]];
      double least_sq = kInfinity;
      for (const auto& f : faces) least_sq = std::min(least_sq, distance_sq_of_tet_and_triangle(tet, f));
      if (least_sq <= depth * depth) expected.push_back(t);
    }
    EXPECT_GT(expected.size(), 20U);
    EXPECT_LT(expected.size(), mesh.tets.size());
    EXPECT_EQ(kept_numbers({patch(center, 0.3, depth)}, mesh), expected) << depth;
  }
}

TEST(Sizing, KeptVerticesAreThoseOfKeptTets) {
  const TetMesh two = testing_support::make_two_tets();
  EXPECT_EQ(build_kept_vertices({1, 0}, two), (std::vector<std::uint8_t>{1, 1, 1, 1, 0}));
  EXPECT_EQ(build_kept_vertices({0, 1}, two), (std::vector<std::uint8_t>{1, 1, 1, 0, 1}));
  EXPECT_EQ(build_kept_vertices({0, 0}, two), (std::vector<std::uint8_t>(5, 0)));
  EXPECT_THROW(build_kept_vertices({1}, two), ContractError);
}

TEST(Sizing, TheGrowthBoundFollowsItsFormula) {
  const SizingField field(options_of({half_space({1, 0, 0}, 0.0)}, 0.5, 1.0), build_kuhn_cube(1, 0.0, 0));
  GrowthBound growth(field, 1.0);
  EXPECT_EQ(growth.passes(), kGradingPasses);
  // A corner tet of side a has the volume a^3 / 6 and its barycenter at x + a / 4.
  const auto admits = [&](double x, double a) {
    return growth.admits({Vec3{x, 0, 0}, {x + a, 0, 0}, {x, a, 0}, {x, 0, a}});
  };
  for (const double x : {-1.0, 0.1, 0.4, 0.7, 2.0}) {
    for (int pass = 0; pass < 4; ++pass) {
      growth.start_pass(pass);
      for (const double a : {0.5, 0.9, 1.2, 1.6, 2.0, 2.5}) {
        const double size = field.relative_size({x + 0.25 * a, 0.25 * a, 0.25 * a});
        EXPECT_EQ(admits(x, a), a * a * a / 6.0 < std::pow(size, 3) * std::pow(2.0, pass))
            << x << ' ' << a << ' ' << pass;
      }
    }
  }
  growth.start_pass(kGradingPasses);
  EXPECT_TRUE(admits(0.0, 100.0));
  const SizingField flat(options_of({half_space({1, 0, 0}, 0.0)}, 1.0, 1.0), build_kuhn_cube(1, 0.0, 0));
  EXPECT_EQ(GrowthBound(flat, 1.0).passes(), 0);
  EXPECT_EQ(GrowthBound(SizingField(), 1.0).passes(), 0);
}

TEST(Sizing, RefusesWhatMakesNoSense) {
  const TetMesh mesh = build_kuhn_cube(2, 0.0, 0);
  const auto refuse = [&](const SizingOptions& options, const std::string& part) {
    try {
      SizingField field(options, mesh);
      ADD_FAILURE() << part;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
    }
  };
  const double nan = std::nan("");
  refuse(options_of({sphere({0, 0, 0}, 0.0)}), "a radius above 0");
  refuse(options_of({sphere({0, 0, 0}, nan)}), "a radius above 0");
  refuse(options_of({sphere({0, nan, 0}, 1.0)}), "a finite center");
  refuse(options_of({half_space({0, 0, 0}, 1.0)}), "a normal that is finite and not 0");
  refuse(options_of({half_space({0, 0, 1}, kInfinity)}), "a finite offset");
  refuse(options_of({patch({0, 0, 0}, 0.5, -0.1)}), "a depth of at least 0");
  refuse(options_of({patch({0, 0, 2}, 0.5, 0.1)}), "found the nearest one 1 away");
  refuse(options_of({patch({0.5, 0.5, 0.5}, 0.1, 0.1)}), "a vertex of the boundary within the radius 0.1");
  refuse(options_of({}, 0.0), "near_size: expected a number above 0, at most 1, found 0");
  refuse(options_of({}, 1.5), "near_size");
  refuse(options_of({}, 0.5, -1.0), "reach");
  refuse(options_of({}, 0.5, kInfinity), "reach");
}

}  // namespace
}  // namespace palpate::simplify

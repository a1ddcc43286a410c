#include "core/judge/surface/feature_distance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/judge/surface/surface.h"
#include "core/mesh/shapes/shapes.h"
#include "tests/support/small_meshes.h"

namespace palpate::judge {
namespace {

using namespace palpate::testing_support;  // NOLINT(google-build-using-namespace)

TEST(SharpEdges, OfABlockAreThoseOfItsTwelveSides) {
  const SurfaceMesh skin = build_boundary(make_kuhn_block(3, 4, 5));
  EXPECT_EQ(list_sharp_edges(skin, 40.0).size(), 4U * (3 + 4 + 5));
  EXPECT_EQ(list_sharp_edges(skin, 89.9).size(), 4U * (3 + 4 + 5));
  EXPECT_EQ(list_sharp_edges(skin, 90.1).size(), 0U);
  const std::size_t triangles = skin.triangles.size();
  EXPECT_EQ(list_sharp_edges(skin, -1.0).size(), triangles / 2 * 3);  // all of them
}

TEST(SharpEdges, ARoofOfAKnownAngle) {
  for (const double degrees : {5.0, 30.0, 90.0, 150.0, 179.0}) {
    const double turn = degrees * 3.14159265358979323846 / 180.0;
    const Vec3 over{0.0, std::cos(turn), std::sin(turn)};
    const SurfaceMesh roof{{{0, 0, 0}, {1, 0, 0}, {0, -1, 0}, over}, {{0, 2, 1}, {0, 1, 3}}};
    const auto count = [&](double angle) { return list_sharp_edges(roof, angle).size(); };
    EXPECT_EQ(count(degrees - 0.01), 5U) << degrees;  // four of one triangle each, and the ridge
    EXPECT_EQ(count(degrees + 0.01), 4U) << degrees;
  }
}

TEST(SharpEdges, RefusesWhatIsNoSurface) {
  const double nan = std::nan("");
  EXPECT_THROW(list_sharp_edges({{{0, 0, 0}}, {{0, 1, 2}}}, 40.0), ContractError);
  EXPECT_THROW(list_sharp_edges({{{0, 0, 0}, {1, 0, 0}, {0, nan, 0}}, {{0, 1, 2}}}, 40.0), ContractError);
  EXPECT_THROW(measure_feature_distance({}, {}, 0.0), ContractError);
  EXPECT_THROW(measure_feature_distance({}, {}, nan), ContractError);
}

TEST(TotalBend, ClosedForms) {
  constexpr double kPi = 3.14159265358979323846;
  // A block's twelve sides, however finely it is cut, wherever it lies and however large it is.
  for (const int n : {1, 2, 5}) {
    SurfaceMesh cube = build_boundary(make_kuhn_block(n, n, n));
    for (Vec3& p : cube.points) p = (1e-3 / n) * p + Vec3{7.0, -5.0, 3.0};
    EXPECT_NEAR(total_bend(cube), 12e-3 * kPi / 2.0, 1e-12) << n;
  }
  EXPECT_NEAR(total_bend(build_boundary(make_kuhn_block(2, 3, 4))), 4.0 * (2 + 3 + 4) * kPi / 2.0, 1e-12);
  const SurfaceMesh regular{{{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}},
                            {{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}}};
  EXPECT_NEAR(total_bend(regular), 6.0 * std::sqrt(8.0) * (kPi - std::acos(1.0 / 3.0)), 1e-12);
  // An edge of one triangle alone is bent by nothing.
  EXPECT_EQ(total_bend({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}}), 0.0);
  EXPECT_EQ(total_bend({}), 0.0);
  EXPECT_THROW(total_bend({{{0, 0, 0}}, {{0, 1, 2}}}), ContractError);
}

TEST(TotalBend, OfARoundBodyComesNearItsCurvatureAndACrumpledSkinHasMore) {
  constexpr double kPi = 3.14159265358979323846;
  TetMesh ball = make_kuhn_block(12, 12, 12);
  for (Vec3& p : ball.points) {  // each shell of the cube onto a sphere
    const Vec3 q = p - Vec3{6, 6, 6};
    const double shell = std::max({std::fabs(q.x), std::fabs(q.y), std::fabs(q.z)});
    const double size = length(q);
    p = size > 0.0 ? (shell / size) * q : q;
  }
  SurfaceMesh skin = build_boundary(ball);
  const double smooth = total_bend(skin);
  // Twice 4 pi r, and more where the shell's quadrangles are bent along the wrong diagonal.
  EXPECT_GT(smooth, 8.0 * kPi * 6.0);
  EXPECT_LT(smooth, 1.2 * 8.0 * kPi * 6.0);
  SplitMix64 random(4);
  for (Vec3& p : skin.points) p = (1.0 + 0.02 * (random.uniform() - 0.5)) * p;
  EXPECT_GT(total_bend(skin), 1.1 * smooth);
}

TEST(EdgeDistance, ClosedForms) {
  const std::vector<EdgeEnds> ground{{Vec3{0, 0, 0}, Vec3{4, 0, 0}}};
  const auto distance = [&](const Vec3& a, const Vec3& b) {
    const EdgeDistance found = measure_edge_distance({{a, b}}, ground);
    EXPECT_LE(found.lower, found.upper);
    EXPECT_LE(found.upper, std::max(1.001 * found.lower, found.lower + 1e-6));
    return found.lower;
  };
  EXPECT_EQ(distance({1, 0, 0}, {3, 0, 0}), 0.0);
  EXPECT_EQ(distance({1, 0, 2}, {3, 0, 2}), 2.0);
  EXPECT_EQ(distance({1, 0, 0}, {7, 0, 0}), 3.0);
  EXPECT_EQ(distance({4, 3, 0}, {7, 0, 4}), 5.0);
  // A gap: farthest in its middle.
  const std::vector<EdgeEnds> apart{{Vec3{0, 0, 0}, Vec3{1, 0, 0}}, {Vec3{2, 0, 0}, Vec3{4, 0, 0}}};
  EXPECT_NEAR(measure_edge_distance(ground, apart).lower, 0.5, 5e-4);
  EXPECT_GE(measure_edge_distance(ground, apart).upper, 0.5);
  EXPECT_EQ(measure_edge_distance(apart, ground).upper, 0.0);
  EXPECT_EQ(measure_edge_distance({}, ground).upper, 0.0);
  EXPECT_EQ(measure_edge_distance(ground, {}).lower, std::numeric_limits<double>::infinity());
}

TEST(EdgeDistance, AgreesWithSamples) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    SplitMix64 random(seed);
    const auto edges = [&](int count) {
      std::vector<EdgeEnds> all;
      for (int i = 0; i < count; ++i) {
        const Vec3 from{random.uniform(), random.uniform(), random.uniform()};
        all.push_back({from, from + 0.3 * Vec3{random.uniform(), random.uniform(), random.uniform()}});
      }
      return all;
    };
    const auto a = edges(6);
    const auto b = edges(9);
    double sampled = 0.0;
    for (const auto& [p, q] : a) {
      for (int k = 0; k <= 400; ++k) {
        const Vec3 at = p + (k / 400.0) * (q - p);
        double nearest = 1e300;
        for (const auto& [r, s] : b) {
          for (int m = 0; m <= 400; ++m)
            nearest = std::min(nearest, length(at - (r + (m / 400.0) * (s - r))));
        }
        sampled = std::max(sampled, nearest);
      }
    }
    const EdgeDistance found = measure_edge_distance(a, b);
    EXPECT_LE(found.lower, sampled + 1e-3) << "seed " << seed;
    EXPECT_GE(found.upper, sampled - 1e-3) << "seed " << seed;
  }
}

TEST(FeatureDistance, SeesAnEdgeThatWasCutOrMoved) {
  const TetMesh block = make_kuhn_block(4, 4, 4);
  const SurfaceMesh skin = build_boundary(block);
  const FeatureDistance same = measure_feature_distance(skin, skin, 40.0);
  EXPECT_EQ(same.input_edges, 48U);
  EXPECT_EQ(same.output_edges, 48U);
  EXPECT_EQ(same.kept.upper, 0.0);
  // A vertex in the middle of an edge goes down by a quarter: so far is the edge off there.
  SurfaceMesh dented = skin;
  for (Vec3& p : dented.points) {
    if (p == Vec3{2, 0, 4}) p = {2, 0, 3.75};
  }
  const FeatureDistance moved = measure_feature_distance(skin, dented, 40.0);
  EXPECT_GT(moved.kept.lower, 0.2);
  EXPECT_LE(moved.kept.upper, 0.25 + 1e-6);
  // A ball in the place of the block has no sharp edge at all.
  const FeatureDistance gone = measure_feature_distance(skin, build_geodesic_sphere(8), 40.0);
  EXPECT_EQ(gone.kept.lower, std::numeric_limits<double>::infinity());
  EXPECT_EQ(measure_feature_distance(build_geodesic_sphere(8), skin, 40.0).kept.upper, 0.0);
}

}  // namespace
}  // namespace palpate::judge

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

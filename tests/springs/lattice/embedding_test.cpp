// Points within the cells of a lattice: linear fields, work on both sides, the nearest cell.
#include "core/springs/lattice/embedding.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/dynamics/linear_algebra/matrix3.h"
#include "core/mesh/shapes/shapes.h"
#include "tests/support/dynamics_cases.h"
#include "tests/support/random_gradient.h"

namespace palpate::springs {
namespace {

using dynamics::Mat3;
using testing_support::coordinate;
using testing_support::make_affine_field;
using testing_support::make_gradient;

/// The largest error of a linear field, relative to the largest displacement.
double linear_field_error(const Lattice& lattice, const Embedding& embedding,
                          const std::vector<Vec3>& points) {
  const Mat3 gradient = make_gradient(5);
  const Vec3 shift{0.01, 0.02, -0.01};
  const std::vector<Vec3> found = interpolate(embedding, make_affine_field(lattice.nodes, gradient, shift));
  const std::vector<Vec3> exact = make_affine_field(points, gradient, shift);
  double worst = 0.0;
  for (std::size_t p = 0; p < points.size(); ++p) worst = std::max(worst, length(found[p] - exact[p]));
  return worst / 0.03;
}

TEST(LatticeEmbedding, ReproducesLinearFieldsInsideAndBeyond) {
  const TetMesh body = build_kuhn_cube(3, 0.25, 8);
  SplitMix64 random(17);
  std::vector<Vec3> points = body.points;
  for (int k = 0; k < 500; ++k)
    points.push_back(
        {1.4 * random.uniform() - 0.2, 1.4 * random.uniform() - 0.2, 1.4 * random.uniform() - 0.2});
  for (const LatticeKind kind : {LatticeKind::kHexahedral, LatticeKind::kBodyCentred}) {
    for (const LatticeBoundary boundary : {LatticeBoundary::kWeight, LatticeBoundary::kRemove}) {
      LatticeOptions options;
      options.kind = kind;
      options.boundary = boundary;
      options.spacing_m = 0.23;
      options.turn_deg = 15.0;
      const Lattice lattice = build_lattice(body, options);
      Embedding embedding = build_embedding(lattice, points);
      EXPECT_GT(embedding.outside, 0U);
      EXPECT_LT(linear_field_error(lattice, embedding, points), 1e-12);
      // Force and displacement do the same work on both sides.
      const std::vector<Vec3> u = testing_support::make_random_field(lattice.nodes.size(), 1.0, 3);
      const std::vector<Vec3> f = testing_support::make_random_field(points.size(), 1.0, 4);
      std::vector<Vec3> back(lattice.nodes.size());
      carry_back(embedding, f, back);
      const std::vector<Vec3> there = interpolate(embedding, u);
      double at_points = 0.0;
      double at_nodes = 0.0;
      for (std::size_t p = 0; p < f.size(); ++p) at_points += dot(f[p], there[p]);
      for (std::size_t v = 0; v < u.size(); ++v) at_nodes += dot(back[v], u[v]);
      EXPECT_NEAR(at_points, at_nodes, 1e-11 * std::fabs(at_points) + 1e-10);
      // The oracle sees a field that is taken from one node alone.
      for (std::size_t p = 0; p + 1 < embedding.offsets.size(); ++p) {
        for (Index k = embedding.offsets[p]; k < embedding.offsets[p + 1]; ++k)
          embedding.weights[k] = k == embedding.offsets[p] ? 1.0 : 0.0;
      }
      EXPECT_GT(linear_field_error(lattice, embedding, points), 0.01);
    }
  }
}

TEST(LatticeEmbedding, FindsTheNearestCell) {
  const TetMesh body = build_kuhn_cube(3, 0.25, 8);
  LatticeOptions options;
  options.spacing_m = 0.19;
  options.boundary = LatticeBoundary::kRemove;
  options.fraction = 0.9;
  const Lattice lattice = build_lattice(body, options);
  SplitMix64 random(2);
  std::vector<Vec3> points(200);
  for (Vec3& point : points)
    point = {3.0 * random.uniform() - 1.0, 3.0 * random.uniform() - 1.0, 3.0 * random.uniform() - 1.0};
  double farthest = 0.0;
  std::size_t outside = 0;
  for (const Vec3& x : points) {
    const Vec3 p = lattice.frame.to_cells(x);
    double least = 1e9;
    for (const std::array<int, 3>& place : lattice.place) {
      double sum = 0.0;
      for (int i = 0; i < 3; ++i) {
        const double at = coordinate(p, i);
        const double low = place[static_cast<std::size_t>(i)];
        const double off = std::max({low - at, at - low - 1.0, 0.0});
        sum += off * off;
      }
      least = std::min(least, std::sqrt(sum));
    }
    farthest = std::max(farthest, least);
    outside += least > 0.0 ? 1 : 0;
  }
  const Embedding embedding = build_embedding(lattice, points);
  EXPECT_EQ(embedding.outside, outside);
  EXPECT_NEAR(embedding.farthest_cells, farthest, 1e-12);
  EXPECT_THROW(build_embedding(lattice, std::vector<Vec3>{{std::nan(""), 0, 0}}), InputError);
}

}  // namespace
}  // namespace palpate::springs

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/judge/displacement/displacement.h"
#include "core/judge/displacement/tet_tree.h"
#include "core/mesh/geometry.h"
#include "core/mesh/shapes/shapes.h"
#include "core/mesh/topology.h"
#include "tests/support/small_meshes.h"

namespace palpate::judge {
namespace {

using namespace palpate::testing_support;  // NOLINT(google-build-using-namespace)

Vec3 affine(const Vec3& p) {
  return {1.0 + 2.0 * p.x - p.y, 0.5 * p.z + p.x, -3.0 + p.y + 4.0 * p.z};
}

Vec3 bent(const Vec3& p) {
  return {p.x * p.y, p.z * p.z, std::sin(3.0 * p.x)};
}

std::vector<Vec3> values(std::span<const Vec3> points, Vec3 (*function)(const Vec3&)) {
  std::vector<Vec3> field;
  for (const Vec3& p : points) field.push_back(function(p));
  return field;
}

Vec3 random_point(SplitMix64& random, double low, double high) {
  const auto draw = [&] { return low + (high - low) * random.uniform(); };
  const double x = draw();
  const double y = draw();
  return {x, y, draw()};
}

/// Adds so many of them.
void add_random_points(std::vector<Vec3>& points, std::size_t count, SplitMix64& random, double low,
                       double high) {
  points.reserve(points.size() + count);
  for (std::size_t i = 0; i < count; ++i) points.push_back(random_point(random, low, high));
}

double distance_to(const Vec3& a, const Vec3& b) {
  return length(a - b);
}

/// By trying all tets: volumes of the four parts over the whole. Nothing if no tet holds p.
bool find_by_force(const TetMesh& mesh, std::span<const Vec3> field, const Vec3& p, Vec3& value) {
  for (const Tet& t : mesh.tets) {
    const auto& x = mesh.points;
    const double whole = signed_volume(x[t[0]], x[t[1]], x[t[2]], x[t[3]]);
    const double a = signed_volume(p, x[t[1]], x[t[2]], x[t[3]]) / whole;
    const double b = signed_volume(x[t[0]], p, x[t[2]], x[t[3]]) / whole;
    const double c = signed_volume(x[t[0]], x[t[1]], p, x[t[3]]) / whole;
    const double d = signed_volume(x[t[0]], x[t[1]], x[t[2]], p) / whole;
    if (std::min({a, b, c, d}) < 0.0) continue;
    value = a * field[t[0]] + b * field[t[1]] + c * field[t[2]] + d * field[t[3]];
    return true;
  }
  return false;
}

/// The nearest of very many points of the boundary faces, on a grid of each face.
double nearest_by_force(const TetMesh& mesh, std::span<const Vec3> field, const Vec3& p, Vec3& value) {
  constexpr int kSteps = 60;
  double best = std::numeric_limits<double>::infinity();
  for (const Triangle& t : palpate::build_boundary(mesh)) {
    for (int i = 0; i <= kSteps; ++i) {
      for (int j = 0; i + j <= kSteps; ++j) {
        const double b = static_cast<double>(i) / kSteps;
        const double c = static_cast<double>(j) / kSteps;
        const auto blend = [&](std::span<const Vec3> of) {
          return (1.0 - b - c) * of[t[0]] + b * of[t[1]] + c * of[t[2]];
        };
        const double distance = distance_to(p, blend(mesh.points));
        if (distance < best) {
          best = distance;
          value = blend(field);
        }
      }
    }
  }
  return best;
}

TEST(TransferField, GivesTheVerticesBackToTheBit) {
  const TetMesh mesh = build_kuhn_cube(5, 0.35, 4);
  const std::vector<Vec3> field = values(mesh.points, bent);
  const TransferredField found = transfer_field(mesh, field, mesh.points);
  for (std::size_t v = 0; v < field.size(); ++v) EXPECT_LE(distance_to(found.value[v], field[v]), 1e-14);
  EXPECT_EQ(found.outside, 0U);
}

TEST(TransferField, IsExactForLinearFieldsInside) {
  const TetMesh mesh = build_kuhn_cube(5, 0.35, 4);
  SplitMix64 random(12);
  std::vector<Vec3> points;
  add_random_points(points, 2000, random, 0.0, 1.0);
  for (int i = 0; i < 200; ++i) {  // on faces, edges and vertices of the unit cube
    Vec3 p = random_point(random, 0.0, 1.0);
    p.x = i % 2;
    if (i % 3 > 0) p.y = (i / 2) % 2;
    if (i % 3 > 1) p.z = (i / 4) % 2;
    points.push_back(p);
  }
  const TransferredField found = transfer_field(mesh, values(mesh.points, affine), points);
  for (std::size_t i = 0; i < points.size(); ++i)
    EXPECT_LE(distance_to(found.value[i], affine(points[i])), 1e-13);
  EXPECT_EQ(found.outside, 0U);
  EXPECT_LE(found.farthest_outside, 1e-15);
}

TEST(TransferField, MidpointsAndCentroidsOfTheMeshAreInside) {
  const TetMesh mesh = build_bar(3);
  std::vector<Vec3> points;
  for (const Tet& t : mesh.tets) {
    const auto& x = mesh.points;
    points.push_back(0.25 * (x[t[0]] + x[t[1]] + x[t[2]] + x[t[3]]));
    points.push_back((1.0 / 3.0) * (x[t[0]] + x[t[1]] + x[t[2]]));
    points.push_back(0.5 * (x[t[0]] + x[t[3]]));
  }
  const TransferredField found = transfer_field(mesh, values(mesh.points, affine), points);
  EXPECT_EQ(found.outside, 0U);
  for (std::size_t i = 0; i < points.size(); ++i)
    EXPECT_LE(distance_to(found.value[i], affine(points[i])), 1e-13);
}

TEST(TransferField, AgreesWithTryingAllTets) {
  const TetMesh mesh = build_kuhn_cube(4, 0.35, 8);
  const std::vector<Vec3> field = values(mesh.points, bent);
  SplitMix64 random(33);
  std::vector<Vec3> points;
  add_random_points(points, 500, random, 0.0, 1.0);
  const TransferredField found = transfer_field(mesh, field, points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    Vec3 expected;
    ASSERT_TRUE(find_by_force(mesh, field, points[i], expected));
    EXPECT_LE(distance_to(found.value[i], expected), 1e-13);
  }
}

// The ring has a hole and re-entrant edges: points outside lie before faces, edges and corners.
TEST(TransferField, OutsideTakesTheNearestPointOfTheBoundary) {
  const TetMesh mesh = make_cube_ring();
  const std::vector<Vec3> field = values(mesh.points, bent);
  SplitMix64 random(5);
  std::vector<Vec3> points;
  add_random_points(points, 60, random, -2.0, 5.0);
  add_random_points(points, 20, random, 1.0, 2.0);  // in the hole, if z < 1
  const TransferredField found = transfer_field(mesh, field, points);
  std::size_t outside = 0;
  double farthest = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    Vec3 expected;
    if (find_by_force(mesh, field, points[i], expected)) {
      EXPECT_LE(distance_to(found.value[i], expected), 1e-13);
      continue;
    }
    const double distance = nearest_by_force(mesh, field, points[i], expected);
    ++outside;
    farthest = std::max(farthest, distance);
    // The grid of 60 steps is off by at most sqrt(2) / 60, over which `bent` changes by less than 10 times
    // that.
    EXPECT_LE(distance_to(found.value[i], expected), 0.25) << i;
  }
  EXPECT_EQ(found.outside, outside);
  EXPECT_NEAR(found.farthest_outside, farthest, 0.02);
}

TEST(TransferField, OutsideByHand) {
  const TetMesh mesh = make_corner_tet();
  const std::vector<Vec3> field = values(mesh.points, affine);
  const std::vector<Vec3> points{{0.25, 0.25, -2}, {0.5, -3, -4}, {-1, -1, -1}, {1, 1, 1}, {2, -1, -1}};
  const std::vector<Vec3> nearest{
      {0.25, 0.25, 0}, {0.5, 0, 0}, {0, 0, 0}, {1.0 / 3, 1.0 / 3, 1.0 / 3}, {1, 0, 0}};
  const TransferredField found = transfer_field(mesh, field, points);
  for (std::size_t i = 0; i < points.size(); ++i)
    EXPECT_LE(distance_to(found.value[i], affine(nearest[i])), 1e-14) << i;
  EXPECT_EQ(found.outside, 5U);
  EXPECT_NEAR(found.farthest_outside, 5.0, 1e-14);
}

TEST(TransferField, FlatAndIsolatedPartsDoNoHarm) {
  TetMesh mesh = make_kuhn_block(2, 2, 2);
  const auto last = static_cast<Index>(mesh.points.size());
  mesh.points.insert(mesh.points.end(),
                     {{9, 9, 9}, {0.5, 0.5, 1}, {0.6, 0.5, 1}, {0.5, 0.6, 1}, {0.6, 0.6, 1}});
  mesh.tets.push_back({last + 1, last + 2, last + 3, last + 4});  // flat
  const std::vector<Vec3> field = values(mesh.points, affine);
  const std::vector<Vec3> points{{0.55, 0.55, 1}, {1.3, 0.2, 0.7}};
  const TransferredField found = transfer_field(mesh, field, points);
  EXPECT_EQ(found.outside, 0U);
  for (std::size_t i = 0; i < points.size(); ++i)
    EXPECT_LE(distance_to(found.value[i], affine(points[i])), 1e-14);
}

// The figures of a contestant on a coarser mesh hold its error of interpolation: with the wrong rows, or with
// the values of another field, they must tell.
TEST(TransferField, RejectsABrokenField) {
  const TetMesh coarse = build_kuhn_cube(4, 0.2, 3);
  const TetMesh fine = build_kuhn_cube(8, 0.2, 4);
  const std::vector<Vec3> truth = values(fine.points, bent);
  std::vector<Vec3> field = values(coarse.points, bent);
  const auto error = [&] {
    return compare_displacement(fine, transfer_field(coarse, field, fine.points).value, truth, 1.0, 1.0)
        .relative_l2;
  };
  // |u''| h^2 / 8 with h = sqrt(3) / 4 x 1.4 and |u''| <= 9, over a norm of about 0.8: at most 0.5; measured
  // 0.06.
  EXPECT_LT(error(), 0.5);
  const double good = error();
  std::reverse(field.begin(), field.end());
  EXPECT_GT(error(), 5.0 * good);
}

TEST(TransferField, BadInput) {
  const TetMesh mesh = make_corner_tet();
  const std::vector<Vec3> field(4);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(transfer_field(mesh, std::vector<Vec3>(3), {}), ContractError);
  EXPECT_THROW(transfer_field(TetMesh{mesh.points, {}}, field, {}), ContractError);
  EXPECT_THROW(transfer_field(TetMesh{mesh.points, {{0, 1, 2, 4}}}, field, {}), ContractError);
  EXPECT_THROW(transfer_field(mesh, std::vector<Vec3>(4, Vec3{0, nan, 0}), {}), InputError);
  EXPECT_THROW(transfer_field(mesh, field, std::vector<Vec3>{{nan, 0, 0}}), InputError);
  EXPECT_TRUE(transfer_field(mesh, field, {}).value.empty());
}

// Rows of midpoints: a quadratic field is carried over exactly, inside the body and on its flat sides.
TEST(DisplacementTransfer, AQuadraticFieldIsExactAtAllPointsOfTheBody) {
  const auto curved = [](const Vec3& p) {
    return Vec3{p.x * p.x - p.y * p.z, 2.0 * p.y * p.y, p.x * p.z + p.y};
  };
  const TetMesh mesh = build_kuhn_cube(3, 0.3, 8);
  const std::vector<Vec3> nodes = with_midpoints(mesh, mesh.points);
  std::vector<Vec3> field;
  field.reserve(nodes.size());
  for (const Vec3& p : nodes) field.push_back(curved(p));
  SplitMix64 random(5);
  std::vector<Vec3> points{{0, 0, 0}, {1, 1, 1}, {0.3, 0.4, 1.0}};
  add_random_points(points, 300, random, 0.0, 1.0);
  const TransferredField moved = transfer_field(mesh, field, points);
  EXPECT_EQ(moved.outside, 0U);
  for (std::size_t i = 0; i < points.size(); ++i)
    EXPECT_LE(distance_to(moved.value[i], curved(points[i])), 1e-13) << i;
  // Without its midpoints the same field is off by the order of h^2.
  const TransferredField linear =
      transfer_field(mesh, std::span<const Vec3>(field).first(mesh.points.size()), points);
  double most = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i)
    most = std::max(most, distance_to(linear.value[i], curved(points[i])));
  EXPECT_GT(most, 0.02);
}

// Outside, the value of the nearest point of the skin, by the face's own quadratic shape functions.
TEST(DisplacementTransfer, OutsideAQuadraticFieldIsTakenFromTheSkin) {
  const auto curved = [](const Vec3& p) { return Vec3{p.x * p.x, p.x * p.y, p.y * p.y}; };
  const TetMesh mesh = build_kuhn_cube(2, 0.2, 9);
  std::vector<Vec3> field;
  for (const Vec3& p : with_midpoints(mesh, mesh.points)) field.push_back(curved(p));
  const std::vector<Vec3> points{{0.3, 0.7, 1.5}, {0.61, 0.22, -0.1}};
  const TransferredField moved = transfer_field(mesh, field, points);
  EXPECT_EQ(moved.outside, 2U);
  for (std::size_t i = 0; i < points.size(); ++i)
    EXPECT_LE(distance_to(moved.value[i], curved(points[i])), 1e-13) << i;
}

}  // namespace
}  // namespace palpate::judge

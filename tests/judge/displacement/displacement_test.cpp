#include "core/judge/displacement/displacement.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/judge/mesh/tet_edges.h"
#include "core/mesh/geometry.h"
#include "core/mesh/shapes/shapes.h"
#include "core/mesh/topology.h"
#include "tests/support/small_meshes.h"

namespace palpate::judge {
namespace {

using namespace palpate::testing_support;  // NOLINT(google-build-using-namespace)

constexpr double kLambda = 3.0;
constexpr double kMu = 2.0;

/// A matrix by its rows.
using Matrix = std::array<Vec3, 3>;

Vec3 times(const Matrix& m, const Vec3& p) {
  return {dot(m[0], p), dot(m[1], p), dot(m[2], p)};
}

/// Turned by 50 degrees about (1, 2, 2) / 3.
Vec3 turned(const Vec3& p) {
  const double angle = 50.0 * std::acos(-1.0) / 180.0;
  const Vec3 axis{1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0};
  return std::cos(angle) * p + std::sin(angle) * cross(axis, p) +
         (1.0 - std::cos(angle)) * dot(axis, p) * axis;
}

std::vector<Vec3> random_displacements(std::size_t count, std::uint64_t seed) {
  SplitMix64 random(seed);
  std::vector<Vec3> field(count);
  for (Vec3& u : field) u = {random.uniform() - 0.3, random.uniform() - 0.5, random.uniform() - 0.7};
  return field;
}

template <typename Function>
std::vector<Vec3> field_of(std::span<const Vec3> points, Function function) {
  std::vector<Vec3> field;
  for (const Vec3& p : points) field.push_back(function(p));
  return field;
}

/// The vertices and then the midpoints of the edges.
std::vector<Vec3> quadratic_points(const TetMesh& mesh) {
  return with_midpoints(mesh, mesh.points);
}

TEST(DisplacementEdges, AreThoseOfTheMeshInItsOrder) {
  const TetMesh mesh = build_kuhn_cube(4, 0.3, 5);
  const TetEdges found = number_edges(mesh);
  EXPECT_EQ(found.edges, build_edges(mesh));
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    for (std::size_t k = 0; k < 6; ++k) {
      const Edge edge = found.edges[found.of_tet[t][k]];
      const Index a = mesh.tets[t][static_cast<std::size_t>(kTetEdges[k][0])];
      const Index b = mesh.tets[t][static_cast<std::size_t>(kTetEdges[k][1])];
      EXPECT_EQ(edge, (Edge{std::min(a, b), std::max(a, b)}));
    }
  }
}

TEST(DisplacementShares, AddUpToTheVolume) {
  const TetMesh mesh = build_kuhn_cube(3, 0.3, 7);
  for (const std::size_t rows : {mesh.points.size(), quadratic_points(mesh).size()}) {
    double sum = 0.0;
    for (const double share : volume_shares(mesh, rows)) sum += share;
    EXPECT_NEAR(sum, 1.0, 1e-13);
  }
  EXPECT_THROW(volume_shares(mesh, mesh.points.size() + 1), ContractError);
}

// The eight parts of a tet: a corner has one of them, and the midpoints have the rest.
TEST(DisplacementShares, OfMidpointsAreThoseOfTheRefinementOverAllThreeDiagonals) {
  const TetMesh tet = make_corner_tet();
  // Midpoints of kTetEdges, and the pairs of opposite ones; each diagonal gives four inner tets, which have
  // its two ends, and each of the other four midpoints is in two of them.
  constexpr std::array<std::array<std::size_t, 2>, 3> kDiagonals{{{0, 5}, {1, 4}, {2, 3}}};
  const double part = (1.0 / 6.0) / 8.0;
  std::vector<double> expected(10, 0.0);
  for (std::size_t v = 0; v < 4; ++v) expected[v] = part / 4.0;
  for (const auto& diagonal : kDiagonals) {
    for (std::size_t e = 0; e < 6; ++e) {
      const double inner = e == diagonal[0] || e == diagonal[1] ? 4.0 : 2.0;
      expected[4 + e] += (2.0 + inner) * part / 4.0 / 3.0;  // two corner tets have each midpoint
    }
  }
  const std::vector<double> share = volume_shares(tet, 10);
  for (std::size_t i = 0; i < 10; ++i) EXPECT_NEAR(share[i], expected[i], 1e-15) << i;
}

TEST(DisplacementError, OfAConstantShiftIsItsLength) {
  const TetMesh mesh = build_kuhn_cube(3, 0.3, 1);
  // Not from the origin: the truth (x, 0, 0) has the lumped norm sqrt(sum w x^2), taken here vertex by
  // vertex.
  const std::vector<Vec3> truth = field_of(mesh.points, [](const Vec3& p) { return Vec3{p.x, 0, 0}; });
  std::vector<Vec3> field = truth;
  for (Vec3& u : field) u = u + Vec3{0, 0.03, 0.04};
  double norm_sq = 0.0;
  for (const Tet& tet : mesh.tets) {
    const double volume =
        signed_volume(mesh.points[tet[0]], mesh.points[tet[1]], mesh.points[tet[2]], mesh.points[tet[3]]);
    for (const Index v : tet) norm_sq += 0.25 * volume * mesh.points[v].x * mesh.points[v].x;
  }
  const DisplacementError error = compare_displacement(mesh, field, truth, kLambda, kMu);
  EXPECT_NEAR(error.relative_l2, 0.05 / std::sqrt(norm_sq), 1e-13);
  EXPECT_NEAR(error.relative_max, 0.05, 1e-13);
  EXPECT_NEAR(error.relative_energy, 0.0, 1e-13);  // a shift strains nothing
}

TEST(DisplacementError, FindsTheWorstPoint) {
  const TetMesh mesh = make_kuhn_block(2, 2, 2);
  const std::vector<Vec3> truth = field_of(mesh.points, [](const Vec3& p) { return Vec3{0, p.x, 0}; });
  std::vector<Vec3> field = truth;
  field[11].z += 0.5;
  field[4].z -= 0.4;
  const DisplacementError error = compare_displacement(mesh, field, truth, kLambda, kMu);
  EXPECT_EQ(error.worst_point, 11U);
  EXPECT_NEAR(error.relative_max, 0.25, 1e-15);
}

TEST(DisplacementEnergy, OfAnAffineFieldIsClosedForm) {
  const TetMesh mesh = build_kuhn_cube(3, 0.3, 2);
  const Matrix gradient{{{0.1, 0.2, -0.3}, {0.05, -0.2, 0.4}, {0.7, 0.1, 0.3}}};
  const auto affine = [&](const Vec3& p) { return times(gradient, p) + Vec3{5, 6, 7}; };
  const double xy = 0.125;
  const double yz = 0.25;
  const double zx = 0.2;
  const double expected =
      kLambda * 0.2 * 0.2 + 2 * kMu * (0.01 + 0.04 + 0.09 + 2 * (xy * xy + yz * yz + zx * zx));
  const std::vector<Vec3> linear = field_of(mesh.points, affine);
  EXPECT_NEAR(measure_displacement(mesh, linear, kLambda, kMu).energy, std::sqrt(expected), 1e-12);
  const std::vector<Vec3> quadratic = field_of(quadratic_points(mesh), affine);
  EXPECT_NEAR(measure_displacement(mesh, quadratic, kLambda, kMu).energy, std::sqrt(expected), 1e-12);
}

// u = (x^2, xy, 0) on the unit cube: e_xx = 2x, e_yy = x, e_xy = y/2, so a(u, u) is the integral of
// 9 lambda x^2 + 2 mu (5 x^2 + y^2 / 2) = 3 lambda + 11/3 mu.
TEST(DisplacementEnergy, OfAQuadraticFieldIsClosedFormWithMidpointsAlone) {
  const TetMesh mesh = build_kuhn_cube(3, 0.3, 2);
  const auto bent = [](const Vec3& p) { return Vec3{p.x * p.x, p.x * p.y, 0}; };
  const double expected = std::sqrt(3.0 * kLambda + 11.0 / 3.0 * kMu);
  const std::vector<Vec3> quadratic = field_of(quadratic_points(mesh), bent);
  EXPECT_NEAR(measure_displacement(mesh, quadratic, kLambda, kMu).energy, expected, 1e-12);
  const std::vector<Vec3> linear = field_of(mesh.points, bent);
  EXPECT_GT(std::fabs(measure_displacement(mesh, linear, kLambda, kMu).energy - expected), 1e-3);
}

// Rows of midpoints that are means of the ends are the same field, and have the same energy.
TEST(DisplacementEnergy, MidpointsOfALinearFieldChangeNothing) {
  const TetMesh mesh = build_kuhn_cube(3, 0.3, 4);
  const std::vector<Vec3> field = random_displacements(mesh.points.size(), 9);
  const std::vector<Vec3> all = with_midpoints(mesh, field);
  ASSERT_EQ(all.size(), mesh.points.size() + build_edges(mesh).size());
  EXPECT_EQ(with_midpoints(mesh, all), all);
  const double linear = measure_displacement(mesh, field, kLambda, kMu).energy;
  EXPECT_NEAR(measure_displacement(mesh, all, kLambda, kMu).energy, linear, 1e-12 * linear);
}

TEST(DisplacementError, DoesNotDependOnFrameScaleOrStiffness) {
  const TetMesh mesh = build_kuhn_cube(3, 0.3, 6);
  TetMesh other = mesh;
  for (Vec3& p : other.points) p = 0.001 * turned(p) + Vec3{3, -2, 1};
  for (const std::size_t rows : {mesh.points.size(), quadratic_points(mesh).size()}) {
    const std::vector<Vec3> truth = random_displacements(rows, 21);
    const std::vector<Vec3> field = random_displacements(rows, 22);
    const auto move = [](const Vec3& u) { return 0.02 * turned(u); };
    const DisplacementError here = compare_displacement(mesh, field, truth, kLambda, kMu);
    const DisplacementError there =
        compare_displacement(other, field_of(field, move), field_of(truth, move), 1e4 * kLambda, 1e4 * kMu);
    // The points are moved by 3 after scaling to 0.001 of 1/3: 16 - 4 digits of the tets' shapes are left.
    EXPECT_NEAR(there.relative_l2, here.relative_l2, 1e-10);
    EXPECT_NEAR(there.relative_max, here.relative_max, 1e-10);
    EXPECT_NEAR(there.relative_energy, here.relative_energy, 1e-10);
    EXPECT_EQ(there.worst_point, here.worst_point);
  }
}

TEST(DisplacementError, IsZeroForTheTruthAndOneForNothing) {
  const TetMesh mesh = build_kuhn_cube(2, 0.2, 6);
  const std::vector<Vec3> truth = random_displacements(mesh.points.size(), 3);
  const DisplacementError none = compare_displacement(mesh, truth, truth, kLambda, kMu);
  EXPECT_EQ(none.relative_l2 + none.relative_max + none.relative_energy, 0.0);
  const std::vector<Vec3> still(truth.size());
  const DisplacementError all = compare_displacement(mesh, still, truth, kLambda, kMu);
  EXPECT_NEAR(all.relative_l2, 1.0, 1e-14);
  EXPECT_NEAR(all.relative_max, 1.0, 1e-14);
  EXPECT_NEAR(all.relative_energy, 1.0, 1e-14);
}

// What a broken contestant might hand in: a factor, a sign, axes or rows that were mixed up. Each must show
// in each figure.
TEST(DisplacementError, RejectsBrokenAnswers) {
  const TetMesh mesh = build_kuhn_cube(3, 0.2, 6);
  const std::vector<Vec3> truth = field_of(mesh.points, [](const Vec3& p) {
    return Vec3{p.x * p.x, 0.3 * p.x * p.y, -p.z * p.x};
  });
  const auto is_noticed = [&](const std::vector<Vec3>& field, double least) {
    const DisplacementError error = compare_displacement(mesh, field, truth, kLambda, kMu);
    return error.relative_l2 > least && error.relative_max > least && error.relative_energy > least;
  };
  std::vector<Vec3> shifted(truth.begin() + 1, truth.end());
  shifted.push_back(truth[0]);
  EXPECT_TRUE(is_noticed(field_of(truth, [](const Vec3& u) { return 1.05 * u; }), 0.049999));
  EXPECT_FALSE(is_noticed(field_of(truth, [](const Vec3& u) { return 1.05 * u; }), 0.050001));
  EXPECT_TRUE(is_noticed(field_of(truth, [](const Vec3& u) { return -1.0 * u; }), 1.999));
  EXPECT_TRUE(is_noticed(field_of(truth, [](const Vec3& u) { return Vec3{u.y, u.x, u.z}; }), 0.1));
  EXPECT_TRUE(is_noticed(shifted, 0.1));
}

TEST(DisplacementError, BadFieldsAreRefused) {
  const TetMesh mesh = make_kuhn_block(1, 1, 1);
  const std::vector<Vec3> good = random_displacements(8, 1);
  const auto compare = [&](const std::vector<Vec3>& field, const std::vector<Vec3>& truth) {
    compare_displacement(mesh, field, truth, kLambda, kMu);
  };
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    std::vector<Vec3> broken = good;
    broken[5].y = bad;
    EXPECT_THROW(compare(broken, good), InputError);
    EXPECT_THROW(compare(good, broken), InputError);
  }
  EXPECT_THROW(compare(good, std::vector<Vec3>(8)), InputError);                 // moves nothing
  EXPECT_THROW(compare(good, std::vector<Vec3>(8, Vec3{1, 2, 3})), InputError);  // strains nothing
  EXPECT_THROW(compare(good, random_displacements(9, 1)), ContractError);
  EXPECT_THROW(compare(random_displacements(9, 1), random_displacements(9, 1)), ContractError);
  EXPECT_THROW(compare_displacement(mesh, good, good, kLambda, 0.0), ContractError);
  EXPECT_THROW(compare_displacement(mesh, good, good, -2.0, kMu), ContractError);
}

}  // namespace
}  // namespace palpate::judge

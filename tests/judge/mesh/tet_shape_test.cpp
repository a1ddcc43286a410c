#include "core/judge/mesh/tet_shape.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/judge/mesh/judge.h"
#include "tests/support/angles.h"
#include "tests/support/judged_tets.h"
#include "tests/support/small_meshes.h"

namespace palpate::judge {
namespace {

using test::kDegree;
using test::kPi;
using namespace palpate::testing_support;  // NOLINT(google-build-using-namespace)

constexpr double kUnit = std::numeric_limits<double>::epsilon();
constexpr double kShapeRounding = 32 * kUnit;  // a few dozen operations on numbers near 1

/// A random tet, positively oriented, with 6 V of at least 0.01.
TetMesh random_tet(SplitMix64& random) {
  while (true) {
    TetMesh mesh =
        one_tet(random_point(random), random_point(random), random_point(random), random_point(random));
    if (shape_of(mesh).volume.value > 0.01 / 6.0) return mesh;
  }
}

/// tan(angle / 2) = p . q x r / (pqr + (p . q) r + (q . r) p + (r . p) q): the textbook formula (van Oosterom
/// and Strackee 1983), which the judge doesn't use.
double textbook_solid_angle(const Vec3& apex, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 p = a - apex;
  const Vec3 q = b - apex;
  const Vec3 r = c - apex;
  const double below = length(p) * length(q) * length(r) + dot(p, q) * length(r) + dot(q, r) * length(p) +
                       dot(r, p) * length(q);
  return 2.0 * std::atan2(std::fabs(dot(p, cross(q, r))), below);
}

double textbook_min_solid_angle(const TetMesh& mesh) {
  const auto& p = mesh.points;
  return std::min({textbook_solid_angle(p[0], p[1], p[2], p[3]), textbook_solid_angle(p[1], p[0], p[2], p[3]),
                   textbook_solid_angle(p[2], p[0], p[1], p[3]),
                   textbook_solid_angle(p[3], p[0], p[1], p[2])});
}

TEST(TetShape, RegularTetByClosedForm) {
  const TetShape shape = shape_of(make_regular_tet());
  EXPECT_TRUE(shape.is_positive);
  EXPECT_NEAR(shape.min_dihedral, std::acos(1.0 / 3.0), kShapeRounding);
  EXPECT_NEAR(shape.max_dihedral, std::acos(1.0 / 3.0), kShapeRounding);
  EXPECT_NEAR(shape.min_solid_angle, 3.0 * std::acos(1.0 / 3.0) - kPi, kShapeRounding);
  EXPECT_NEAR(shape.edge_ratio, 1.0, kShapeRounding);
  EXPECT_NEAR(shape.volume.value, std::sqrt(2.0) / 12.0, kShapeRounding);
}

TEST(TetShape, CornerTetByClosedForm) {
  const TetShape shape = shape_of(make_corner_tet());
  EXPECT_NEAR(shape.max_dihedral, kPi / 2.0, kShapeRounding);
  EXPECT_NEAR(shape.min_dihedral, std::acos(1.0 / std::sqrt(3.0)), kShapeRounding);
  EXPECT_NEAR(shape.min_solid_angle, 2.0 * std::acos(1.0 / std::sqrt(3.0)) + kPi / 2.0 - kPi, kShapeRounding);
  EXPECT_NEAR(shape.edge_ratio, std::sqrt(0.5), kShapeRounding);
  EXPECT_EQ(shape.volume.value, 1.0 / 6.0);
}

TEST(TetShape, KuhnTetsByClosedForm) {
  // Dihedral angles 45, 45, 60, 90, 90, 90 degrees; six tets fill the cube's corners on the long diagonal,
  // so the angle there is a sixth of pi / 2 each: pi / 12, and it is the least.
  const TetMesh mesh = make_kuhn_block(1, 1, 1);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    const TetShape shape = shape_of(mesh, t);
    EXPECT_NEAR(shape.min_dihedral, 45.0 * kDegree, kShapeRounding);
    EXPECT_NEAR(shape.max_dihedral, 90.0 * kDegree, kShapeRounding);
    EXPECT_NEAR(shape.min_solid_angle, kPi / 12.0, kShapeRounding);
    EXPECT_NEAR(shape.edge_ratio, 1.0 / std::sqrt(3.0), kShapeRounding);
  }
}

TEST(TetShape, RatiosByClosedForm) {
  const TetShape regular = shape_of(make_regular_tet());
  EXPECT_NEAR(regular.mean_ratio, 1.0, kShapeRounding);
  EXPECT_NEAR(regular.radius_ratio, 1.0, kShapeRounding);
  // Corner tet: V = 1/6, squared edges 3 + 6; areas 3/2 + sqrt(3)/2, R = sqrt(3)/2.
  const TetShape corner = shape_of(make_corner_tet());
  EXPECT_NEAR(corner.mean_ratio, 12.0 * std::pow(0.5, 2.0 / 3.0) / 9.0, kShapeRounding);
  EXPECT_NEAR(corner.radius_ratio, std::sqrt(3.0) - 1.0, kShapeRounding);
  // Kuhn tet: V = 1/6, squared edges 1, 1, 1, 2, 2, 3; areas 1/2, 1/2, sqrt(2)/2 twice; R half the cube's
  // diagonal.
  const TetShape kuhn = shape_of(make_kuhn_block(1, 1, 1));
  EXPECT_NEAR(kuhn.mean_ratio, 1.2 * std::pow(0.5, 2.0 / 3.0), kShapeRounding);
  EXPECT_NEAR(kuhn.radius_ratio, 3.0 * (0.5 / (1.0 + std::sqrt(2.0))) / (std::sqrt(3.0) / 2.0),
              kShapeRounding);
}

TEST(TetShape, RatiosAgreeWithTextbookFormulas) {
  constexpr std::uint64_t kSeed = 202;
  SCOPED_TRACE(kSeed);
  SplitMix64 random(kSeed);
  for (int i = 0; i < 2000; ++i) {
    const TetMesh mesh = random_tet(random);
    const TetShape shape = shape_of(mesh);
    const auto& p = mesh.points;
    // R from the products of opposite edges (Crelle): 24 V R = sqrt((a + b + c)(-a + b + c)(a - b + c)(a + b
    // - c)).
    const double a = length(p[1] - p[0]) * length(p[3] - p[2]);
    const double b = length(p[2] - p[0]) * length(p[3] - p[1]);
    const double c = length(p[3] - p[0]) * length(p[2] - p[1]);
    const double volume = shape.volume.value;
    const double outer = std::sqrt((a + b + c) * (-a + b + c) * (a - b + c) * (a + b - c)) / (24.0 * volume);
    double area = 0.0;
    double squares = 0.0;
    for (std::size_t v = 0; v < 4; ++v) {
      const Vec3& o = p[(v + 1) % 4];
      area += 0.5 * length(cross(p[(v + 2) % 4] - o, p[(v + 3) % 4] - o));
      for (std::size_t w = 0; w < v; ++w) squares += dot(p[v] - p[w], p[v] - p[w]);
    }
    // 6 V >= 0.01: Crelle's differences lose up to 10^4 roundings, and so does the judge's sum.
    EXPECT_NEAR(shape.radius_ratio, 9.0 * volume / area / outer, 1e4 * kShapeRounding);
    EXPECT_NEAR(shape.mean_ratio, 12.0 * std::cbrt(9.0 * volume * volume) / squares, kShapeRounding);
    EXPECT_LT(shape.mean_ratio, 1.0);
    EXPECT_LT(shape.radius_ratio, 1.0);
  }
}

TEST(TetShape, SolidAngleAgreesWithTheTextbookFormula) {
  constexpr std::uint64_t kSeed = 201;
  SCOPED_TRACE(kSeed);
  SplitMix64 random(kSeed);
  for (int i = 0; i < 5000; ++i) {
    const TetMesh mesh = random_tet(random);
    // 6 V >= 0.01 with edges below sqrt(3): the sines of all angles are above 0.01 / 3^1.5, so either formula
    // loses at most a factor of 600 to cancellation.
    EXPECT_NEAR(shape_of(mesh).min_solid_angle, textbook_min_solid_angle(mesh), 600 * kShapeRounding);
  }
}

TEST(TetShape, NeedlesKeepTheRelativePrecisionOfSmallSolidAngles) {
  // Seen from far away, an equilateral triangle of area A at distance h fills A / h^2 (1 + O(1 / h^2)).
  const double area = std::sqrt(3.0) / 4.0;
  for (const double h : {1e3, 1e5, 1e7, 1e10, 1e15}) {
    TetMesh mesh = make_regular_tet();
    mesh.points[3].z = h;
    const TetShape shape = shape_of(mesh);
    EXPECT_NEAR(shape.min_solid_angle / (area / (h * h)), 1.0, 1.0 / (h * h) + 1e-14) << h;
    EXPECT_NEAR(shape.min_solid_angle / textbook_min_solid_angle(mesh), 1.0, 1e-12) << h;
  }
}

TEST(TetShape, BothFormsOfTheSolidAngleAgreeWhereTheyMeet) {
  // The judge changes formula at 10^-3 sr: no step there beyond the rounding of the difference, 10^-15 /
  // 10^-3.
  for (int i = 0; i < 200; ++i) {
    const double h = 20.0 + 0.01 * i;  // area / h^2 passes 10^-3 at h = 20.8
    TetMesh mesh = make_regular_tet();
    mesh.points[3].z = h;
    EXPECT_NEAR(shape_of(mesh).min_solid_angle / textbook_min_solid_angle(mesh), 1.0, 1e-11) << h;
  }
}

/// Two crossing diagonals of length 2, h apart: positive, and flat as h goes to 0.
///
/// The faces at the lower diagonal hold the directions (0, +-1, h), so the dihedral angle there is
/// 2 atan(1 / h). The faces at a side have the upward normals (0, -h, 1) and (h, 0, 1), so the dihedral angle
/// d there has cos d = 1 / (1 + h^2), that is tan(d / 2) = h / sqrt(2 + h^2).
TetMesh make_sliver(double h) {
  return one_tet({1, 0, 0}, {-1, 0, 0}, {0, -1, h}, {0, 1, h});
}

TEST(TetShape, SliversByClosedForm) {
  for (const double h : {1e-2, 1e-5, 1e-9, 1e-12, 1e-100}) {
    const TetMesh mesh = make_sliver(h);
    const TetShape s = shape_of(mesh);
    ASSERT_TRUE(s.is_positive);
    EXPECT_NEAR(s.max_dihedral, 2.0 * std::atan(1.0 / h), kShapeRounding);
    const double side = 2.0 * std::atan(h / std::sqrt(2.0 + h * h));
    EXPECT_NEAR(s.min_dihedral / side, 1.0, kShapeRounding) << h;
    // V = 2 h / 3; squared edges 4 + 4 + 4 (2 + h^2); areas 4 sqrt(1 + h^2); R^2 = 1 + h^2 / 4, the center
    // half way up.
    EXPECT_NEAR(s.mean_ratio / (12.0 * std::cbrt(4.0 * h * h) / (16.0 + 4.0 * h * h)), 1.0, kShapeRounding)
        << h;
    const double ratio = 1.5 * h / (std::sqrt(1.0 + h * h) * std::sqrt(1.0 + 0.25 * h * h));
    EXPECT_NEAR(s.radius_ratio, ratio, kShapeRounding) << h;
    // pi - 2 atan(1 / h) = 2 atan(h): the sum of eq. 4.2 without its cancellation.
    const double solid_angle = 2.0 * side - 2.0 * std::atan(h);
    EXPECT_NEAR(s.min_solid_angle / solid_angle, 1.0, 4 * kShapeRounding) << h;
    EXPECT_NEAR(s.min_solid_angle / textbook_min_solid_angle(mesh), 1.0, 1e-12) << h;
  }
}

TEST(TetShape, SliverOfAThousandthOfADegree) {
  const double t = std::tan(0.5e-3 * kDegree);
  const TetMesh mesh = make_sliver(t * std::sqrt(2.0 / (1.0 - t * t)));
  const Quality q = measure_quality(mesh);
  EXPECT_NEAR(q.min_dihedral_deg, 1e-3, 1e-14);
  EXPECT_GT(q.min_quality, 0.0);
  // Any numbering of the vertices gives the same shape.
  const std::array<Tet, 3> turns{{{1, 2, 0, 3}, {2, 0, 1, 3}, {1, 0, 3, 2}}};
  for (const Tet& turn : turns) {
    TetMesh other = mesh;
    for (std::size_t k = 0; k < 4; ++k) other.tets[0][k] = mesh.tets[0][turn[k]];
    EXPECT_NEAR(measure_quality(other).min_quality / q.min_quality, 1.0, 1e-11);
  }
}

TEST(TetShape, DegenerateTetsHaveDefinedShapes) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::array<TetMesh, 6> bad{one_tet({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}),
                                   one_tet({0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}),
                                   one_tet({1, 1, 1}, {1, 1, 1}, {1, 1, 1}, {1, 1, 1}),
                                   one_tet({0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {0, 0, 1}),
                                   one_tet({nan, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}),
                                   one_tet({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1 / 0.0})};
  for (const TetMesh& mesh : bad) {
    const TetShape s = shape_of(mesh);
    EXPECT_FALSE(s.is_positive);
    EXPECT_EQ(s.min_dihedral, 0.0);
    EXPECT_EQ(s.min_solid_angle, 0.0);
    EXPECT_EQ(s.max_dihedral, kPi);
    EXPECT_EQ(s.mean_ratio, 0.0);
    EXPECT_EQ(s.radius_ratio, 0.0);
    EXPECT_TRUE(std::isfinite(s.volume.value) && std::isfinite(s.edge_ratio));
    const Quality q = measure_quality(mesh);
    EXPECT_EQ(q.mean_quality, 0.0);
    EXPECT_EQ(q.max_dihedral_deg, 180.0);
    EXPECT_TRUE(std::isfinite(q.volume) && std::isfinite(q.ideal_volume));
  }
}

}  // namespace
}  // namespace palpate::judge

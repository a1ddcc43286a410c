#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/judge/mesh/judge.h"
#include "core/judge/mesh/tet_shape.h"
#include "tests/support/small_meshes.h"

namespace palpate::judge {
namespace {

using namespace palpate::testing_support;  // NOLINT(google-build-using-namespace)

constexpr double kPi = std::numbers::pi;
constexpr double kDegree = kPi / 180.0;
constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
constexpr double kRounding = 32 * kEpsilon;  // a few dozen operations on numbers near 1

TetShape shape_of(const TetMesh& mesh, std::size_t t = 0) {
  const auto& p = mesh.points;
  const Tet& v = mesh.tets[t];
  return measure_tet(p[v[0]], p[v[1]], p[v[2]], p[v[3]]);
}

TetMesh one_tet(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  return {{a, b, c, d}, {{0, 1, 2, 3}}};
}

Vec3 random_point(SplitMix64& random) {
  return {random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5};
}

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
  EXPECT_NEAR(shape.min_dihedral, std::acos(1.0 / 3.0), kRounding);
  EXPECT_NEAR(shape.max_dihedral, std::acos(1.0 / 3.0), kRounding);
  EXPECT_NEAR(shape.min_solid_angle, 3.0 * std::acos(1.0 / 3.0) - kPi, kRounding);
  EXPECT_NEAR(shape.edge_ratio, 1.0, kRounding);
  EXPECT_NEAR(shape.volume.value, std::sqrt(2.0) / 12.0, kRounding);
}

TEST(TetShape, CornerTetByClosedForm) {
  const TetShape shape = shape_of(make_corner_tet());
  EXPECT_NEAR(shape.max_dihedral, kPi / 2.0, kRounding);
  EXPECT_NEAR(shape.min_dihedral, std::acos(1.0 / std::sqrt(3.0)), kRounding);
  EXPECT_NEAR(shape.min_solid_angle, 2.0 * std::acos(1.0 / std::sqrt(3.0)) + kPi / 2.0 - kPi, kRounding);
  EXPECT_NEAR(shape.edge_ratio, std::sqrt(0.5), kRounding);
  EXPECT_EQ(shape.volume.value, 1.0 / 6.0);
}

TEST(TetShape, KuhnTetsByClosedForm) {
  // Dihedral angles 45, 45, 60, 90, 90, 90 degrees; six tets fill the cube's corners on the long diagonal,
  // so the angle there is a sixth of pi / 2 each: pi / 12, and it is the least.
  const TetMesh mesh = make_kuhn_block(1, 1, 1);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    const TetShape shape = shape_of(mesh, t);
    EXPECT_NEAR(shape.min_dihedral, 45.0 * kDegree, kRounding);
    EXPECT_NEAR(shape.max_dihedral, 90.0 * kDegree, kRounding);
    EXPECT_NEAR(shape.min_solid_angle, kPi / 12.0, kRounding);
    EXPECT_NEAR(shape.edge_ratio, 1.0 / std::sqrt(3.0), kRounding);
  }
}

TEST(TetShape, RatiosByClosedForm) {
  const TetShape regular = shape_of(make_regular_tet());
  EXPECT_NEAR(regular.mean_ratio, 1.0, kRounding);
  EXPECT_NEAR(regular.radius_ratio, 1.0, kRounding);
  // Corner tet: V = 1/6, squared edges 3 + 6; areas 3/2 + sqrt(3)/2, R = sqrt(3)/2.
  const TetShape corner = shape_of(make_corner_tet());
  EXPECT_NEAR(corner.mean_ratio, 12.0 * std::pow(0.5, 2.0 / 3.0) / 9.0, kRounding);
  EXPECT_NEAR(corner.radius_ratio, std::sqrt(3.0) - 1.0, kRounding);
  // Kuhn tet: V = 1/6, squared edges 1, 1, 1, 2, 2, 3; areas 1/2, 1/2, sqrt(2)/2 twice; R half the cube's
  // diagonal.
  const TetShape kuhn = shape_of(make_kuhn_block(1, 1, 1));
  EXPECT_NEAR(kuhn.mean_ratio, 1.2 * std::pow(0.5, 2.0 / 3.0), kRounding);
  EXPECT_NEAR(kuhn.radius_ratio, 3.0 * (0.5 / (1.0 + std::sqrt(2.0))) / (std::sqrt(3.0) / 2.0), kRounding);
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
    EXPECT_NEAR(shape.radius_ratio, 9.0 * volume / area / outer, 1e4 * kRounding);
    EXPECT_NEAR(shape.mean_ratio, 12.0 * std::cbrt(9.0 * volume * volume) / squares, kRounding);
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
    EXPECT_NEAR(shape_of(mesh).min_solid_angle, textbook_min_solid_angle(mesh), 600 * kRounding);
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
    EXPECT_NEAR(s.max_dihedral, 2.0 * std::atan(1.0 / h), kRounding);
    const double side = 2.0 * std::atan(h / std::sqrt(2.0 + h * h));
    EXPECT_NEAR(s.min_dihedral / side, 1.0, kRounding) << h;
    // V = 2 h / 3; squared edges 4 + 4 + 4 (2 + h^2); areas 4 sqrt(1 + h^2); R^2 = 1 + h^2 / 4, the center
    // half way up.
    EXPECT_NEAR(s.mean_ratio / (12.0 * std::cbrt(4.0 * h * h) / (16.0 + 4.0 * h * h)), 1.0, kRounding) << h;
    const double ratio = 1.5 * h / (std::sqrt(1.0 + h * h) * std::sqrt(1.0 + 0.25 * h * h));
    EXPECT_NEAR(s.radius_ratio, ratio, kRounding) << h;
    // pi - 2 atan(1 / h) = 2 atan(h): the sum of eq. 4.2 without its cancellation.
    const double solid_angle = 2.0 * side - 2.0 * std::atan(h);
    EXPECT_NEAR(s.min_solid_angle / solid_angle, 1.0, 4 * kRounding) << h;
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

TEST(Quality, RegularTetReaches1_00078) {
  const Quality q = measure_quality(make_regular_tet());
  const double expected = std::cbrt((3.0 * std::acos(1.0 / 3.0) - kPi) / 0.55);
  EXPECT_NEAR(q.mean_quality, expected, kRounding);
  EXPECT_NEAR(q.mean_quality, 1.00078, 1e-5);
  EXPECT_EQ(q.histogram[9], 1U);  // the excess over 1 counts in the last bucket
  EXPECT_EQ(q.percent_above_0_6, 100.0);
}

TEST(Quality, KuhnCubeByClosedForm) {
  const Quality q = measure_quality(make_kuhn_block(3, 2, 2));
  const double expected = std::cbrt(kPi / 12.0 / 0.55 / std::sqrt(3.0));
  EXPECT_NEAR(q.mean_quality, expected, kRounding);
  EXPECT_NEAR(q.min_quality, expected, kRounding);
  EXPECT_NEAR(q.volume, 12.0, 12.0 * kRounding);
  EXPECT_NEAR(q.ideal_volume, 1.0 / 6.0, kRounding);
  EXPECT_NEAR(q.min_dihedral_deg, 45.0, 45.0 * kRounding);
  EXPECT_NEAR(q.p1_dihedral_deg, 45.0, 45.0 * kRounding);
  EXPECT_NEAR(q.max_dihedral_deg, 90.0, 90.0 * kRounding);
  EXPECT_EQ(q.histogram[static_cast<std::size_t>(10.0 * expected)], 72U);
}

TEST(Quality, VolumeFactorIsClamped) {
  // Two corner tets, one 8 times the other: ideal 4.5 of the small one's volume.
  TetMesh big = make_corner_tet();
  for (Vec3& p : big.points) p = 2.0 * p;
  const TetMesh both = join_meshes(translated(big, {5, 5, 5}), make_corner_tet());
  const double shape = std::cbrt((2.0 * std::acos(1.0 / std::sqrt(3.0)) - kPi / 2.0) / 0.55 * std::sqrt(0.5));
  const Quality q = measure_quality(both);
  EXPECT_NEAR(q.min_quality, shape * std::cbrt(1.0 / 4.5), kRounding);
  EXPECT_NEAR(q.mean_quality, shape * (1.0 + std::cbrt(1.0 / 4.5)) / 2.0, kRounding);  // 8 / 4.5 counts as 1
}

TEST(Quality, IdealVolumeOfTheInput) {
  const TetMesh mesh = make_corner_tet();
  const Quality own = measure_quality(mesh);
  const Quality given = measure_quality(mesh, 1.0);
  EXPECT_EQ(given.ideal_volume, 1.0);
  EXPECT_NEAR(given.mean_quality, own.mean_quality * std::cbrt(1.0 / 6.0), kRounding);
  EXPECT_EQ(measure_quality(mesh, 0.01).mean_quality, own.mean_quality);
  EXPECT_THROW(measure_quality(mesh, -1.0), ContractError);
  EXPECT_THROW(measure_quality(mesh, std::nan("")), ContractError);
}

TEST(Quality, TetsThatAreNotPositiveHaveQualityZero) {
  TetMesh mesh = make_kuhn_block(2, 2, 2);
  std::swap(mesh.tets[0][0], mesh.tets[0][1]);
  const Quality q = measure_quality(mesh);
  EXPECT_EQ(q.histogram[0], 1U);
  EXPECT_EQ(q.min_quality, 0.0);
  EXPECT_EQ(q.min_dihedral_deg, 0.0);
  EXPECT_EQ(q.p1_dihedral_deg, 0.0);  // 48 tets: rank 1
  EXPECT_EQ(q.max_dihedral_deg, 180.0);
  EXPECT_EQ(q.p99_max_dihedral_deg, 180.0);
  for (const Spread& spread : {q.mean_ratio, q.radius_ratio, q.edge_ratio}) {
    EXPECT_EQ(spread.least, 0.0);
    EXPECT_EQ(spread.p1, 0.0);
    EXPECT_GT(spread.p5, 0.0);  // rank 3 of 48
  }
  EXPECT_NEAR(q.edge_ratio.mean, 47.0 / 48.0 / std::sqrt(3.0), kRounding);
  EXPECT_NEAR(q.volume, 8.0 - 2.0 / 6.0, 8.0 * kRounding);
  for (Tet& t : mesh.tets) std::swap(t[0], t[1]);  // all but one: the volume is negative, no ideal exists
  EXPECT_EQ(measure_quality(mesh).mean_quality, 0.0);
}

/// A block with its inner vertices moved at random by up to 0.2.
TetMesh shaken_block(std::uint64_t seed) {
  TetMesh mesh = make_kuhn_block(5, 5, 5);
  SplitMix64 random(seed);
  for (const Index v : interior_vertices_of_block(5, 5, 5)) {
    mesh.points[v] = mesh.points[v] + 0.4 * random_point(random);
  }
  return mesh;
}

TEST(Quality, HistogramAndPercentagesFollowFromTheQualities) {
  const TetMesh mesh = shaken_block(7);
  const Quality q = measure_quality(mesh);
  std::array<std::uint64_t, 10> histogram{};
  std::vector<double> dihedrals;
  int above_half = 0;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    const TetShape s = shape_of(mesh, t);
    const double quality =
        std::cbrt(s.min_solid_angle / 0.55 * s.edge_ratio * std::min(1.0, s.volume.value / (125.0 / 750.0)));
    ++histogram[static_cast<std::size_t>(std::min(10.0 * quality, 9.0))];
    above_half += quality > 0.5 ? 1 : 0;
    dihedrals.push_back(s.min_dihedral / kDegree);
  }
  EXPECT_EQ(q.histogram, histogram);
  EXPECT_EQ(std::accumulate(q.histogram.begin(), q.histogram.end(), std::uint64_t{0}), mesh.tets.size());
  EXPECT_NEAR(q.percent_above_0_5, 100.0 * above_half / 750.0, 1e-12);
  std::sort(dihedrals.begin(), dihedrals.end());
  EXPECT_NEAR(q.min_dihedral_deg, dihedrals[0], 1e-12);
  EXPECT_NEAR(q.p1_dihedral_deg, dihedrals[7], 1e-12);   // ceil(7.5) = 8th
  EXPECT_NEAR(q.p5_dihedral_deg, dihedrals[37], 1e-12);  // ceil(37.5) = 38th
}

TEST(Quality, RatiosAndGreatestAnglesAreThoseOfTheTets) {
  const TetMesh mesh = shaken_block(9);
  const Quality q = measure_quality(mesh);
  std::vector<double> greatest;
  std::vector<double> radius;
  double sum = 0.0;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    const TetShape s = shape_of(mesh, t);
    greatest.push_back(s.max_dihedral / kDegree);
    radius.push_back(s.radius_ratio);
    sum += s.mean_ratio / 750.0;
  }
  std::sort(greatest.begin(), greatest.end());
  std::sort(radius.begin(), radius.end());
  EXPECT_NEAR(q.max_dihedral_deg, greatest.back(), 1e-12);
  EXPECT_NEAR(q.p99_max_dihedral_deg, greatest[742], 1e-12);  // ceil(742.5) = 743rd
  EXPECT_NEAR(q.p95_max_dihedral_deg, greatest[712], 1e-12);  // ceil(712.5) = 713th
  EXPECT_NEAR(q.mean_ratio.mean, sum, 1e-12);
  EXPECT_EQ(q.radius_ratio.least, radius[0]);
  EXPECT_EQ(q.radius_ratio.p1, radius[7]);
  EXPECT_EQ(q.radius_ratio.p5, radius[37]);
}

TEST(Quality, OneSliverShowsInTheTailsAlone) {
  // 100 regular tets, of which one is pressed flat: the mean hardly moves, the tails do.
  TetMesh mesh = make_regular_tet();
  for (int i = 1; i < 100; ++i) mesh = join_meshes(mesh, make_regular_tet());
  const Quality before = measure_quality(mesh);
  mesh.points[3].z = 1e-6;
  const Quality q = measure_quality(mesh);
  EXPECT_GT(q.mean_ratio.mean, 0.99 * before.mean_ratio.mean - kRounding);
  EXPECT_LT(q.mean_ratio.p1, 1e-3);
  EXPECT_LT(q.radius_ratio.least, 1e-3);
  EXPECT_NEAR(q.mean_ratio.p5, 1.0, kRounding);
  EXPECT_GT(q.max_dihedral_deg, 179.0);
  EXPECT_NEAR(q.p99_max_dihedral_deg, std::acos(1.0 / 3.0) / kDegree, 1e-12);  // rank 99 of 100
}

TEST(Quality, FirstPercentileIsTheNearestRank) {
  TetMesh mesh = make_corner_tet();
  std::swap(mesh.tets[0][0], mesh.tets[0][1]);  // inverted: counts with an angle of 0
  while (mesh.tets.size() < 100) mesh = join_meshes(mesh, make_corner_tet());
  EXPECT_EQ(measure_quality(mesh).p1_dihedral_deg, 0.0);  // rank 1 of 100
  mesh = join_meshes(mesh, make_corner_tet());
  EXPECT_NEAR(measure_quality(mesh).p1_dihedral_deg, std::acos(1.0 / std::sqrt(3.0)) / kDegree,
              1e-12);  // 2 of 101
  EXPECT_EQ(measure_quality(mesh).min_dihedral_deg, 0.0);
}

TEST(Quality, InvariantUnderRotationOrderAndScale) {
  const TetMesh mesh = shaken_block(8);
  const Quality q = measure_quality(mesh);
  const auto expect_same = [&](const TetMesh& other, double volume_factor) {
    const Quality o = measure_quality(other);
    // Moves round each coordinate once: angles of a mesh of size 9 with edges above 0.3 move by 1e-14.
    EXPECT_NEAR(o.mean_quality, q.mean_quality, 1e-12);
    EXPECT_NEAR(o.min_quality, q.min_quality, 1e-11);
    EXPECT_NEAR(o.min_dihedral_deg, q.min_dihedral_deg, 1e-10);
    EXPECT_NEAR(o.p1_dihedral_deg, q.p1_dihedral_deg, 1e-10);
    EXPECT_NEAR(o.p99_max_dihedral_deg, q.p99_max_dihedral_deg, 1e-10);
    EXPECT_NEAR(o.mean_ratio.mean, q.mean_ratio.mean, 1e-12);
    EXPECT_NEAR(o.radius_ratio.least, q.radius_ratio.least, 1e-11);
    EXPECT_NEAR(o.edge_ratio.p5, q.edge_ratio.p5, 1e-12);
    EXPECT_NEAR(o.volume / volume_factor, q.volume, 1e-11);
  };
  TetMesh other = mesh;
  for (Vec3& p : other.points) {
    const double c = std::cos(0.7);
    const double s = std::sin(0.7);
    p = {c * p.x - s * p.y, s * p.x + c * p.y, p.z};
    p = {p.x, c * p.y - s * p.z, s * p.y + c * p.z};
  }
  expect_same(other, 1.0);
  other = mesh;
  for (Tet& t : other.tets) t = {t[3], t[2], t[1], t[0]};
  std::reverse(other.tets.begin(), other.tets.end());
  expect_same(other, 1.0);
  for (const double scale : {1e-100, 1e-9, 1e9, 1e100}) {
    other = mesh;
    for (Vec3& p : other.points) p = scale * p;
    expect_same(other, scale * scale * scale);
  }
  for (const double scale : {1e-305, 1e-200, 1e200, 1e307}) {  // volumes beyond the range of doubles
    other = mesh;
    for (Vec3& p : other.points) p = scale * p;
    EXPECT_NEAR(measure_quality(other).mean_quality, q.mean_quality, 1e-12) << scale;
    EXPECT_TRUE(std::isfinite(measure_quality(other).volume));
  }
}

TEST(Quality, EmptyMeshAndInvalidIndices) {
  EXPECT_EQ(measure_quality({}).mean_quality, 0.0);
  TetMesh mesh = make_corner_tet();
  mesh.tets.push_back({0, 1, 2, 4});
  EXPECT_THROW(measure_quality(mesh), ContractError);
}

TEST(Quality, Equation4_1GivesTheSupplementOfTheDihedralAngle) {
  // Regular tet, outward normals of two faces: acos(n . m) is pi minus the angle inside, so eq. 4.2 as
  // printed gives 3 (pi - acos(1/3)) - pi, more than a hemisphere's share, in place of 0.55 sr.
  const TetMesh mesh = make_regular_tet();
  const auto& p = mesh.points;
  const auto unit_normal = [&](const std::array<int, 3>& f) {
    const auto at = [&](int k) { return p[static_cast<std::size_t>(f[static_cast<std::size_t>(k)])]; };
    const Vec3 n = cross(at(1) - at(0), at(2) - at(0));
    return 1.0 / length(n) * n;
  };
  const double printed = std::acos(dot(unit_normal(kTetFaces[0]), unit_normal(kTetFaces[1])));
  EXPECT_NEAR(printed, kPi - shape_of(mesh).min_dihedral, kRounding);
  EXPECT_GT((3.0 * printed - kPi) / 0.55, 4.0);
  EXPECT_NEAR(shape_of(mesh).min_solid_angle / 0.55, 1.0, 0.0024);
}

TEST(Quality, WithoutTheClampOfQ3OneTetReachesAnyQuality) {
  // 4.2.3.3 assigns V / ideal to q3 without the clamp of 2.3.5: a big tet among small ones would exceed 1.
  TetMesh big = make_regular_tet();
  for (Vec3& p : big.points) p = 10.0 * p;
  TetMesh mesh = translated(big, {50, 0, 0});
  for (int i = 0; i < 9; ++i) mesh = join_meshes(mesh, translated(make_regular_tet(), {2.0 * i, 0, 0}));
  const TetShape shape = shape_of(mesh);
  const Quality q = measure_quality(mesh);
  const double unclamped = std::cbrt(shape.min_solid_angle / 0.55 * shape.volume.value / q.ideal_volume);
  EXPECT_GT(unclamped, 2.0);
  EXPECT_EQ(q.histogram[9], 1U);
  EXPECT_LT(q.mean_quality, 1.0);
}

}  // namespace
}  // namespace palpate::judge

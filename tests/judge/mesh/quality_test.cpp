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

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
constexpr double kRounding = 32 * kEpsilon;  // a few dozen operations on numbers near 1

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

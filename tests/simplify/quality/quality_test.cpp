#include "core/simplify/quality/quality.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/base/random.h"

namespace palpate::simplify {
namespace {

using Points = std::array<Vec3, 4>;

TetFigures measure(const Points& p, const QualityMetric& metric = kThesisMetric) {
  return measure_tet(metric, p[0], p[1], p[2], p[3]);
}

Points random_tet(SplitMix64& random) {
  Points p;
  do {
    for (Vec3& v : p) v = {random.uniform(), random.uniform(), random.uniform()};
  } while (dot(cross(p[1] - p[0], p[2] - p[0]), p[3] - p[0]) < 0.02);
  return p;
}

TEST(Quality, RegularTetIsSlightlyAboveOne) {
  // Solid angle of a regular tet: 3 acos(1/3) - pi = 0.551286 sr, while the thesis divides by 0.55
  // (docs/errata.md).
  const Points p{Vec3{1, 1, 1}, Vec3{-1, 1, -1}, Vec3{1, -1, -1}, Vec3{-1, -1, 1}};
  const TetFigures f = measure(p);
  ASSERT_TRUE(f.is_positive);
  const double solid_angle = 3.0 * std::acos(1.0 / 3.0) - std::numbers::pi;
  EXPECT_NEAR(f.shape, solid_angle / 0.55, 1e-14);
  EXPECT_NEAR(f.volume, 8.0 / 3.0, 1e-14);
  EXPECT_NEAR(quality_factor(kThesisMetric, f, f.volume), 1.00078, 1e-5);
  EXPECT_NEAR(measure(p, kMeanRatioMetric).shape, 1.0, 1e-14);
}

TEST(Quality, CornerTetHasClosedForm) {
  // Unit corner: solid angle pi/2 at the right corner; at the others 2 atan2(1, sqrt(2) sqrt(2) + sqrt(2) +
  // ...) by Girard: dihedral angles pi/2, pi/2... at each of the three unit edges, acos(1/sqrt(3)) at the
  // long ones.
  const Points p{Vec3{0, 0, 0}, Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};
  const double least = 2.0 * std::acos(1.0 / std::sqrt(3.0)) + std::numbers::pi / 2.0 - std::numbers::pi;
  const TetFigures f = measure(p);
  EXPECT_NEAR(f.shape, least / 0.55 / std::sqrt(2.0), 1e-14);
  EXPECT_NEAR(f.volume, 1.0 / 6.0, 1e-16);
}

TEST(Quality, LeastSolidAngleAgreesWithDihedralAngles) {
  // Eq. 4.2 with interior dihedral angles, against the tangent formula.
  SplitMix64 random(5);
  for (int n = 0; n < 1000; ++n) {
    const Points p = random_tet(random);
    double least = 10.0;
    double shortest = 1e9;
    double longest = 0.0;
    for (std::size_t o = 0; o < 4; ++o) {
      std::array<Vec3, 3> e;
      for (std::size_t i = 0; i < 3; ++i) e[i] = p[(o + 1 + i) % 4] - p[o];
      double angle = -std::numbers::pi;
      for (std::size_t i = 0; i < 3; ++i) {
        const Vec3 left = cross(e[i], e[(i + 1) % 3]);
        const Vec3 right = cross(e[i], e[(i + 2) % 3]);
        angle += std::acos(dot(left, right) / (length(left) * length(right)));
        shortest = std::min(shortest, length(e[i]));
        longest = std::max(longest, length(e[i]));
      }
      least = std::min(least, angle);
    }
    // acos of a rounded cosine is good to sqrt(eps) at worst; these tets are far from flat.
    EXPECT_NEAR(measure(p).shape, least / 0.55 * shortest / longest, 1e-10) << "case " << n;
  }
}

TEST(Quality, ScaleFreeAndTheSameFromEveryCorner) {
  SplitMix64 random(6);
  constexpr std::array<std::array<std::size_t, 4>, 3> kEvenPermutations{
      {{1, 2, 0, 3}, {3, 1, 0, 2}, {1, 0, 3, 2}}};
  for (int n = 0; n < 200; ++n) {
    const Points p = random_tet(random);
    for (const QualityMetric& metric : {kThesisMetric, kMeanRatioMetric}) {
      const TetFigures f = measure(p, metric);
      for (const auto& order : kEvenPermutations) {
        const TetFigures g = measure({p[order[0]], p[order[1]], p[order[2]], p[order[3]]}, metric);
        EXPECT_NEAR(g.shape, f.shape, 1e-12 * (1.0 + 1.0 / f.shape));
        EXPECT_NEAR(g.volume, f.volume, 1e-14);
      }
      const TetFigures scaled = measure({8.0 * p[0], 8.0 * p[1], 8.0 * p[2], 8.0 * p[3]}, metric);
      EXPECT_EQ(scaled.shape, f.shape);  // a power of two changes no digit
      EXPECT_EQ(scaled.volume, 512.0 * f.volume);
    }
  }
}

TEST(Quality, FlatAndInvertedTetsHaveNone) {
  const Points flat{Vec3{0, 0, 0}, Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{1, 1, 0}};
  const Points inverted{Vec3{0, 0, 0}, Vec3{0, 1, 0}, Vec3{1, 0, 0}, Vec3{0, 0, 1}};
  for (const Points& p : {flat, inverted}) {
    const TetFigures f = measure(p);
    EXPECT_FALSE(f.is_positive);
    EXPECT_EQ(f.shape, 0.0);
    EXPECT_EQ(quality_factor(kThesisMetric, f, 1.0), 0.0);
  }
}

TEST(Quality, VolumeFactorIsClampedToOne) {
  const TetFigures f{true, 0.5, 2.0};
  EXPECT_DOUBLE_EQ(quality_factor(kThesisMetric, f, 1.0), std::cbrt(0.5));
  EXPECT_DOUBLE_EQ(quality_factor(kThesisMetric, f, 8.0), std::cbrt(0.5 * 0.25));
  EXPECT_DOUBLE_EQ(quality_factor(kMeanRatioMetric, f, 8.0), std::cbrt(0.5));
}

TEST(Quality, KeyOrdersAsTheFactorDoes) {
  SplitMix64 random(7);
  for (int n = 0; n < 1000; ++n) {
    const TetFigures f{true, random.uniform(), random.uniform()};
    const TetFigures g{true, random.uniform(), random.uniform()};
    const double key_f = quality_key(kThesisMetric, f.shape, f.volume, 0.5);
    const double key_g = quality_key(kThesisMetric, g.shape, g.volume, 0.5);
    if (key_f < key_g) {
      EXPECT_LE(quality_factor(kThesisMetric, f, 0.5), quality_factor(kThesisMetric, g, 0.5));
    }
  }
}

}  // namespace
}  // namespace palpate::simplify

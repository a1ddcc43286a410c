#include "core/mesh/orientation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <string>

#include "core/base/random.h"
#include "tests/support/cgal_oracle.h"

namespace palpate {
namespace {

using Points = std::array<Vec3, 4>;

int sign_of(const Points& p) {
  return orientation(p[0], p[1], p[2], p[3]);
}

int oracle_sign_of(const Points& p) {
  return test::cgal_orientation(p[0], p[1], p[2], p[3]);
}

int rational_sign_of(const Points& p) {
  return test::rational_orientation(p[0], p[1], p[2], p[3]);
}

double in_one(SplitMix64& random) {
  return 2.0 * random.uniform() - 1.0;
}

Vec3 random_point(SplitMix64& random) {
  return {in_one(random), in_one(random), in_one(random)};
}

/// Moves a number by up to `most` units in the last place.
double nudged(double value, int most, SplitMix64& random) {
  int steps = static_cast<int>(random.below(2 * static_cast<std::uint64_t>(most) + 1)) - most;
  for (; steps > 0; --steps) value = std::nextafter(value, std::numeric_limits<double>::infinity());
  for (; steps < 0; ++steps) value = std::nextafter(value, -std::numeric_limits<double>::infinity());
  return value;
}

void nudge(Vec3& p, int most, SplitMix64& random) {
  p = {nudged(p.x, most, random), nudged(p.y, most, random), nudged(p.z, most, random)};
}

/// Three random points and a fourth on their plane, but for rounding and a few units in the last place.
Points near_a_plane(SplitMix64& random) {
  Points p{random_point(random), random_point(random), random_point(random), {}};
  p[3] = p[0] + in_one(random) * (p[1] - p[0]) + in_one(random) * (p[2] - p[0]);
  nudge(p[3], 2, random);
  std::swap(p[3], p[random.below(4)]);
  return p;
}

/// Four points of a small integer lattice, far away or near: very often exactly coplanar.
Points on_a_lattice(SplitMix64& random) {
  const double spacing = std::ldexp(1.0, static_cast<int>(random.below(40)) - 20);
  const double offset = random.below(2) == 0 ? 0.0 : std::ldexp(1.0, 26) * spacing;
  Points p;
  for (Vec3& v : p) {
    v = {offset + spacing * static_cast<double>(random.below(4)),
         offset + spacing * static_cast<double>(random.below(4)),
         offset + spacing * static_cast<double>(random.below(4))};
  }
  return p;
}

/// A tiny tet at a huge distance from the origin: the coordinates differ in their last bits alone.
Points far_away(SplitMix64& random) {
  const Vec3 centre = std::ldexp(1.0, static_cast<int>(random.below(60))) * random_point(random);
  Points p{centre, centre, centre, centre};
  for (Vec3& v : p) nudge(v, 3, random);
  return p;
}

/// Points that share coordinates with one another, as on the faces of a box.
Points with_shared_coordinates(SplitMix64& random) {
  const std::array<double, 3> values{in_one(random), in_one(random), in_one(random)};
  Points p;
  for (Vec3& v : p) v = {values[random.below(3)], values[random.below(3)], values[random.below(3)]};
  if (random.below(2) == 0) nudge(p[random.below(4)], 1, random);
  return p;
}

/// Nearly on a line.
Points near_a_line(SplitMix64& random) {
  const Vec3 start = random_point(random);
  const Vec3 along = random_point(random);
  Points p;
  for (Vec3& v : p) {
    v = start + in_one(random) * along;
    nudge(v, 2, random);
  }
  return p;
}

template <typename Make>
void expect_agreement(const char* kind, const Make& make, int cases) {
  const std::uint64_t seed = 20;
  SplitMix64 random(seed);
  int zeros = 0;
  int wrong = 0;
  constexpr std::array<double, 5> kScales{1.0, 1e-9, 1e9, 1e80, 1e-80};
  for (int i = 0; i < cases; ++i) {
    Points p = make(random);
    const double scale = kScales[static_cast<std::size_t>(i) % kScales.size()];
    for (Vec3& v : p) v = scale * v;
    const int expected = oracle_sign_of(p);
    zeros += expected == 0 ? 1 : 0;
    if (sign_of(p) != expected && wrong++ == 0) {
      ADD_FAILURE() << kind << ", case " << i << ", seed " << seed << ": " << sign_of(p) << " for "
                    << expected;
    }
  }
  EXPECT_EQ(wrong, 0) << kind;
  ::testing::Test::RecordProperty("coplanar", zeros);
}

constexpr int kCases = 400000;

TEST(Orientation, AgreesWithCgalNearAPlane) {
  expect_agreement("near a plane", near_a_plane, 2 * kCases);
}

TEST(Orientation, AgreesWithCgalOnALattice) {
  expect_agreement("on a lattice", on_a_lattice, kCases);
}

TEST(Orientation, AgreesWithCgalFarAway) {
  expect_agreement("far away", far_away, kCases);
}

TEST(Orientation, AgreesWithCgalForSharedCoordinates) {
  expect_agreement("shared coordinates", with_shared_coordinates, kCases);
}

TEST(Orientation, AgreesWithCgalNearALine) {
  expect_agreement("near a line", near_a_line, kCases);
}

TEST(Orientation, AgreesWithCgalForRandomTets) {
  const auto make = [](SplitMix64& random) {
    return Points{random_point(random), random_point(random), random_point(random), random_point(random)};
  };
  expect_agreement("random", make, kCases);
}

TEST(Orientation, AgreesWithRationalArithmeticForMixedMagnitudes) {
  // Each coordinate has an exponent of its own; ratios stay inside the range that the header states.
  SplitMix64 random(8);
  for (int i = 0; i < 40000; ++i) {
    const auto number = [&] { return std::ldexp(in_one(random), static_cast<int>(random.below(290)) - 145); };
    Points p;
    for (Vec3& v : p) v = {number(), number(), number()};
    if (i % 2 == 0) p[3] = p[0] + (p[1] - p[2]);
    if (i % 4 == 0) nudge(p[3], 1, random);
    ASSERT_EQ(sign_of(p), rational_sign_of(p)) << "case " << i << ", seed 8";
  }
}

TEST(Orientation, TheOraclesAgreeWithEachOther) {
  SplitMix64 random(9);
  int zeros = 0;
  for (int i = 0; i < 20000; ++i) {
    const Points p = i % 2 == 0 ? near_a_plane(random) : on_a_lattice(random);
    const int sign = rational_sign_of(p);
    zeros += sign == 0 ? 1 : 0;
    ASSERT_EQ(oracle_sign_of(p), sign) << "case " << i << ", seed 9";
  }
  EXPECT_GT(zeros, 1000);
}

TEST(Orientation, RoundedArithmeticFailsWhereTheTestsLook) {
  // The cases are hard: the determinant in doubles has the wrong sign in many of them.
  SplitMix64 random(20);
  int wrong = 0;
  for (int i = 0; i < 10000; ++i) {
    const Points p = near_a_plane(random);
    const double det = dot(cross(p[1] - p[0], p[2] - p[0]), p[3] - p[0]);
    wrong += ((det > 0.0) - (det < 0.0)) != oracle_sign_of(p) ? 1 : 0;
  }
  EXPECT_GT(wrong, 500);
}

TEST(Orientation, SignFollowsThePermutation) {
  SplitMix64 random(10);
  for (int i = 0; i < 4000; ++i) {
    const Points p = i % 4 == 0   ? near_a_plane(random)
                     : i % 4 == 1 ? far_away(random)
                     : i % 4 == 2 ? with_shared_coordinates(random)
                                  : on_a_lattice(random);
    const int sign = sign_of(p);
    std::array<std::size_t, 4> order{0, 1, 2, 3};
    do {
      int inversions = 0;
      for (std::size_t a = 0; a < 4; ++a) {
        for (std::size_t b = a + 1; b < 4; ++b) inversions += order[a] > order[b] ? 1 : 0;
      }
      const int expected = inversions % 2 == 0 ? sign : -sign;
      ASSERT_EQ(orientation(p[order[0]], p[order[1]], p[order[2]], p[order[3]]), expected)
          << "case " << i << ", seed 10";
    } while (std::next_permutation(order.begin(), order.end()));
  }
}

TEST(Orientation, CoplanarPointsGiveZeroAtEveryScale) {
  for (const double scale : {1.0, 1e-9, 1e9, 1e80, 1e-80, 0.1, 1e-300, 1e300}) {
    const Vec3 a{0.1 * scale, 0.7 * scale, 0.3 * scale};
    const Vec3 b{0.9 * scale, 0.2 * scale, 0.3 * scale};
    const Vec3 c{0.4 * scale, 0.8 * scale, 0.3 * scale};
    EXPECT_EQ(orientation(a, b, c, {0.123 * scale, 0.456 * scale, 0.3 * scale}), 0);
    EXPECT_EQ(orientation(a, b, c, a), 0);
    EXPECT_EQ(orientation(a, b, b, c), 0);
    EXPECT_EQ(orientation(a, a, a, a), 0);
    const double above = std::nextafter(0.3 * scale, std::numeric_limits<double>::infinity());
    const int sign = orientation(a, b, c, {0.123 * scale, 0.456 * scale, above});
    EXPECT_EQ(sign, test::rational_orientation(a, b, c, {0.123 * scale, 0.456 * scale, above}));
    EXPECT_NE(sign, 0) << scale;
  }
  EXPECT_EQ(orientation({}, {}, {}, {}), 0);
}

TEST(Orientation, SignOfAUnitTet) {
  const Vec3 o{0, 0, 0};
  const Vec3 x{1, 0, 0};
  const Vec3 y{0, 1, 0};
  const Vec3 z{0, 0, 1};
  EXPECT_EQ(orientation(o, x, y, z), 1);
  EXPECT_EQ(orientation(o, y, x, z), -1);
  EXPECT_EQ(orientation(o, x, y, x + y), 0);
}

}  // namespace
}  // namespace palpate

#include "core/judge/mesh/exact_orientation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <limits>
#include <sstream>

#include "core/base/random.h"
#include "core/mesh/orientation.h"

namespace palpate::judge {
namespace {

using Whole =
    boost::multiprecision::number<boost::multiprecision::cpp_int_backend<>, boost::multiprecision::et_off>;
using Points = std::array<Vec3, 4>;

/// value * 2^1074, whole for every double: the rational numbers of the brute force share one denominator.
Whole fixed_point(double value) {
  int exponent = 0;
  const double fraction = std::frexp(std::fabs(value), &exponent);
  // |value| 2^1074 = (fraction 2^53) 2^(exponent + 1021); subnormal numbers have zeros to drop at the end.
  const auto mantissa = static_cast<std::int64_t>(std::ldexp(fraction, 53));
  const int shift = exponent + 1021;
  Whole whole = shift >= 0 ? mantissa : mantissa >> -shift;
  if (shift > 0) whole *= Whole(1) << static_cast<unsigned>(shift);
  return value < 0.0 ? Whole(-whole) : whole;
}

/// The sign by brute force: the 24 terms of the 4 x 4 determinant of the rows (x, y, z, 1). Neither the
/// scaling nor the formula is the judge's.
int brute_force_sign(const Points& p) {
  std::array<std::array<Whole, 4>, 4> m;
  for (std::size_t i = 0; i < 4; ++i) {
    m[i] = {fixed_point(p[i].x), fixed_point(p[i].y), fixed_point(p[i].z), Whole(1)};
  }
  std::array<std::size_t, 4> order{0, 1, 2, 3};
  Whole sum = 0;
  do {
    int inversions = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = i + 1; j < 4; ++j) inversions += order[i] > order[j] ? 1 : 0;
    }
    const Whole term = m[0][order[0]] * m[1][order[1]] * m[2][order[2]] * m[3][order[3]];
    sum += inversions % 2 == 0 ? term : Whole(-term);
  } while (std::next_permutation(order.begin(), order.end()));
  return -sum.sign();  // of the rows b - a, c - a, d - a it is minus this determinant
}

int filtered(const Points& p) {
  return exact_orientation(p[0], p[1], p[2], p[3]);
}

int by_integers(const Points& p) {
  return integer_orientation(p[0], p[1], p[2], p[3]);
}

std::string show(const Points& p) {
  std::ostringstream text;
  text << std::hexfloat;
  for (const Vec3& v : p) text << "(" << v.x << " " << v.y << " " << v.z << ") ";
  return text.str();
}

void expect_right(const Points& p) {
  const int expected = brute_force_sign(p);
  ASSERT_EQ(filtered(p), expected) << show(p);
  ASSERT_EQ(by_integers(p), expected) << show(p);
}

/// A whole number in [-range, range].
double small_integer(SplitMix64& random, std::uint64_t range) {
  return static_cast<double>(random.below(2 * range + 1)) - static_cast<double>(range);
}

/// `value` moved by up to two units in the last place.
double nudged(double value, SplitMix64& random) {
  const std::uint64_t steps = random.below(5);
  for (std::uint64_t i = 0; i < steps / 2 + steps % 2; ++i) {
    value = std::nextafter(value, steps % 2 == 0 ? 1e308 : -1e308);
  }
  return value;
}

Vec3 random_point(SplitMix64& random) {
  return {random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5};
}

TEST(ExactOrientation, SmallIntegersAgainstBruteForce) {
  constexpr std::uint64_t kSeed = 101;
  SCOPED_TRACE(kSeed);
  SplitMix64 random(kSeed);
  int flat = 0;
  for (int i = 0; i < 3000; ++i) {
    Points p;
    for (Vec3& v : p) v = {small_integer(random, 2), small_integer(random, 2), small_integer(random, 2)};
    expect_right(p);
    flat += brute_force_sign(p) == 0 ? 1 : 0;
  }
  EXPECT_GT(flat, 100);  // the case that matters does occur
}

TEST(ExactOrientation, NearlyFlatByUnitsInTheLastPlace) {
  constexpr std::uint64_t kSeed = 102;
  SCOPED_TRACE(kSeed);
  SplitMix64 random(kSeed);
  std::array<int, 3> signs{};
  for (int i = 0; i < 3000; ++i) {
    Points p{random_point(random), random_point(random), random_point(random), {}};
    const double s = 2.0 * random.uniform() - 0.5;
    const double t = 2.0 * random.uniform() - 0.5;
    p[3] = p[0] + s * (p[1] - p[0]) + t * (p[2] - p[0]);
    p[3] = {nudged(p[3].x, random), nudged(p[3].y, random), nudged(p[3].z, random)};
    expect_right(p);
    ++signs[static_cast<std::size_t>(std::ptrdiff_t{filtered(p)} + 1)];
    EXPECT_EQ(filtered(p), orientation(p[0], p[1], p[2], p[3])) << show(p);
  }
  EXPECT_GT(signs[0], 1000);
  EXPECT_GT(signs[2], 1000);
}

TEST(ExactOrientation, AroundADiagonalPlaneWhereRoundingLies) {
  // x + y + z = const through points with a common offset: the rounded determinant has the wrong sign here.
  int rounded_wrong = 0;
  const Points base{{{0.5, 0.5, 0.5}, {12, 12, 12}, {24, 24, 24}, {1, 2, 4}}};
  for (int i = 0; i < 16; ++i) {
    for (int j = 0; j < 16; ++j) {
      Points p = base;
      p[0].x += i * 0x1p-53;
      p[0].y += j * 0x1p-53;
      p[0].z += (i + j) * 0x1p-54;
      expect_right(p);
      const Vec3 u = p[1] - p[0];
      const Vec3 v = p[2] - p[0];
      const Vec3 w = p[3] - p[0];
      const double rounded = dot(cross(u, v), w);
      rounded_wrong += (rounded > 0.0) - (rounded < 0.0) != filtered(p) ? 1 : 0;
    }
  }
  EXPECT_GT(rounded_wrong, 10);
}

TEST(ExactOrientation, AllExponentsMixed) {
  constexpr std::uint64_t kSeed = 103;
  SCOPED_TRACE(kSeed);
  SplitMix64 random(kSeed);
  const auto any_double = [&] {
    const int exponent = static_cast<int>(random.below(2098)) - 1074;
    const double value = std::scalbn(1.0 + random.uniform(), exponent);
    return random.below(2) == 0 ? value : -value;
  };
  for (int i = 0; i < 400; ++i) {
    Points p;
    for (Vec3& v : p) v = {any_double(), any_double(), any_double()};
    expect_right(p);
  }
}

TEST(ExactOrientation, WhereTheNumbersOfFixedWidthAreLeftForThoseOfAnySize) {
  // The greatest determinants there are, and nearly flat ones, for exponents 0 and 110 to 120 apart.
  constexpr std::uint64_t kSeed = 104;
  SCOPED_TRACE(kSeed);
  SplitMix64 random(kSeed);
  for (int i = 0; i < 3000; ++i) {
    const int apart = 110 + static_cast<int>(random.below(11));
    const auto extreme = [&] {
      const double value = std::scalbn(2.0 - 0x1p-52, random.below(3) == 0 ? 0 : apart);
      return random.below(2) == 0 ? value : -value;
    };
    Points p;
    for (Vec3& v : p) v = {extreme(), extreme(), extreme()};
    if (random.below(2) == 0) p[3] = {nudged(p[2].x, random), p[2].y, nudged(p[2].z, random)};
    expect_right(p);
  }
}

TEST(ExactOrientation, ACoordinateInCommonIsAPlaneAndNearlyIsNone) {
  constexpr std::uint64_t kSeed = 105;
  SCOPED_TRACE(kSeed);
  SplitMix64 random(kSeed);
  int flat = 0;
  for (int i = 0; i < 3000; ++i) {
    Points p{random_point(random), random_point(random), random_point(random), random_point(random)};
    const double level = std::array{0.3, 0.0, 0x1p-1074, 1e300}.at(random.below(4));
    const std::uint64_t axis = random.below(3);
    for (Vec3& v : p) {
      double& coordinate = axis == 0 ? v.x : axis == 1 ? v.y : v.z;
      coordinate = random.below(8) == 0 ? nudged(level, random) : level;
    }
    expect_right(p);
    flat += filtered(p) == 0 ? 1 : 0;
  }
  EXPECT_GT(flat, 500);
  EXPECT_LT(flat, 2500);
}

TEST(ExactOrientation, UnderflowCannotMisleadTheFilter) {
  // With h = 2^-1074 the minors 0.51 h and -1.49 h round to h and -h. Times 1.2 w and w they sum to -0.878 h
  // w, but to 0.2 h w as computed: the wrong sign, by far more than any bound on rounding alone.
  const double tiny = 0x1p-540;
  for (const double w : {0x1p10, 0x1p200, 0x1p299, 0x1p600, 0x1p1000}) {
    const Points p{{{0, 0, 0}, {1.49 * tiny, 0.51 * tiny, 0}, {0, 0, 0x1p-534}, {1.2 * w, w, 0}}};
    const double rounded = dot(cross(p[1], p[2]), p[3]);
    EXPECT_GT(rounded, 0.0);
    EXPECT_EQ(filtered(p), -1);
    expect_right(p);
  }
}

TEST(ExactOrientation, SubnormalAndHugeCoordinates) {
  const double least = std::numeric_limits<double>::denorm_min();
  const double most = std::numeric_limits<double>::max();
  for (const double s :
       {least, 3 * least, 1e-310, std::numeric_limits<double>::min(), 1e-90, 1e90, 1e308, most}) {
    const Points p{{{0, 0, 0}, {s, 0, 0}, {0, s, 0}, {0, 0, s}}};
    EXPECT_EQ(filtered(p), 1) << s;
    EXPECT_EQ(filtered({p[0], p[2], p[1], p[3]}), -1) << s;
    const Points spread{
        {{-s, -s, -s}, {s, -s, -s}, {-s, s, -s}, {-s, -s, s}}};  // differences overflow at most
    EXPECT_EQ(filtered(spread), 1) << s;
    EXPECT_EQ(filtered({p[0], p[1], p[2], {s, s, 0}}), 0) << s;
    EXPECT_EQ(filtered({p[0], p[1], p[2], {s, s, least}}), 1) << s;
    EXPECT_EQ(filtered({p[0], p[1], p[2], {s, s, -least}}), -1) << s;
  }
}

TEST(ExactOrientation, EvenPermutationsKeepTheSignAndOddOnesTurnIt) {
  constexpr std::uint64_t kSeed = 104;
  SCOPED_TRACE(kSeed);
  SplitMix64 random(kSeed);
  for (int i = 0; i < 200; ++i) {
    Points p;
    for (Vec3& v : p) v = random_point(random);
    p[3] = p[0] + 0.25 * (p[1] - p[0]) + 0.5 * (p[2] - p[0]);
    const int sign = filtered(p);
    EXPECT_EQ(filtered({p[1], p[2], p[0], p[3]}), sign);
    EXPECT_EQ(filtered({p[1], p[0], p[3], p[2]}), sign);
    EXPECT_EQ(filtered({p[1], p[0], p[2], p[3]}), -sign);
    EXPECT_EQ(filtered({p[0], p[3], p[2], p[1]}), -sign);
  }
}

}  // namespace
}  // namespace palpate::judge

#include "core/judge/mesh/exact_orientation.h"

#include <algorithm>
#include <array>
#include <boost/multiprecision/cpp_int.hpp>
#include <climits>
#include <cmath>

namespace palpate::judge {
namespace {

namespace mp = boost::multiprecision;

/// Whole numbers of any size. Expression templates are off: nine products gain nothing from them.
using Whole = mp::number<mp::cpp_int_backend<>, mp::et_off>;

/// Whole numbers that need no memory of their own. They suffice where the exponents are at most
/// kFixedShift apart: docs/exact_orientation.md.
constexpr unsigned kFixedBits = 512;
using FixedWhole =
    mp::number<mp::cpp_int_backend<kFixedBits, kFixedBits, mp::signed_magnitude, mp::unchecked, void>,
               mp::et_off>;
constexpr int kFixedShift = 115;

// The filter's numbers; docs/exact_orientation.md proves that they suffice.
constexpr double kErrorFactor = 9.0 * 0x1p-53;   // 8 roundings a product, and one of slack
constexpr double kLargestDifference = 0x1p300;   // above it products could overflow
constexpr double kSmallestMagnitude = 0x1p-600;  // below it underflow could outweigh the slack
constexpr int kMantissaBits = std::numeric_limits<double>::digits;

/// A double as mantissa * 2^exponent with a whole mantissa of at most 53 bits.
struct Binary {
  std::int64_t mantissa = 0;
  int exponent = 0;
};

Binary split(double value) {
  int exponent = 0;
  const double fraction = std::frexp(value, &exponent);
  return {static_cast<std::int64_t>(std::ldexp(fraction, kMantissaBits)), exponent - kMantissaBits};
}

/// The sign of the determinant of three rows.
template <typename Number>
int determinant_sign(const std::array<std::array<Number, 3>, 3>& m) {
  const Number determinant = m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) +
                             m[0][1] * (m[1][2] * m[2][0] - m[1][0] * m[2][2]) +
                             m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
  return determinant.sign();
}

/// The sign for twelve coordinates, x, y, z of a, b, c, d, in units of 2^unit.
template <typename Number>
int orientation_of(const std::array<Binary, 12>& binaries, int unit) {
  std::array<Number, 12> whole;  // values[i] / 2^unit
  for (std::size_t i = 0; i < binaries.size(); ++i) {
    if (binaries[i].mantissa == 0) continue;
    whole[i] = binaries[i].mantissa;
    whole[i] *= Number(1) << static_cast<unsigned>(binaries[i].exponent - unit);
  }
  std::array<std::array<Number, 3>, 3> rows;
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      rows[row][axis] = whole[3 * (row + 1) + axis] - whole[axis];
    }
  }
  return determinant_sign(rows);
}

}  // namespace

int integer_orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const std::array<double, 12> values{a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z, d.x, d.y, d.z};
  std::array<Binary, 12> binaries;
  int least = INT_MAX;
  int greatest = INT_MIN;
  for (std::size_t i = 0; i < values.size(); ++i) {
    binaries[i] = split(values[i]);
    if (binaries[i].mantissa == 0) continue;
    least = std::min(least, binaries[i].exponent);
    greatest = std::max(greatest, binaries[i].exponent);
  }
  if (greatest < least) return 0;  // all are zero
  if (greatest - least <= kFixedShift) return orientation_of<FixedWhole>(binaries, least);
  return orientation_of<Whole>(binaries, least);
}

int exact_orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const Vec3 u = b - a;
  const Vec3 v = c - a;
  const Vec3 w = d - a;
  const double uv_yz = u.y * v.z;
  const double uv_zy = u.z * v.y;
  const double uv_zx = u.z * v.x;
  const double uv_xz = u.x * v.z;
  const double uv_xy = u.x * v.y;
  const double uv_yx = u.y * v.x;
  const double determinant = ((uv_yz - uv_zy) * w.x + (uv_zx - uv_xz) * w.y) + (uv_xy - uv_yx) * w.z;
  const double magnitude = ((std::fabs(uv_yz) + std::fabs(uv_zy)) * std::fabs(w.x) +
                            (std::fabs(uv_zx) + std::fabs(uv_xz)) * std::fabs(w.y)) +
                           (std::fabs(uv_xy) + std::fabs(uv_yx)) * std::fabs(w.z);
  const double largest =
      std::max({std::fabs(u.x), std::fabs(u.y), std::fabs(u.z), std::fabs(v.x), std::fabs(v.y),
                std::fabs(v.z), std::fabs(w.x), std::fabs(w.y), std::fabs(w.z)});
  if (largest <= kLargestDifference && magnitude >= kSmallestMagnitude) {
    const double bound = kErrorFactor * magnitude;
    if (determinant > bound) return 1;
    if (determinant < -bound) return -1;
  }
  // A difference of doubles is zero where they are the same, and nowhere else: in a plane across an axis.
  if ((u.x == 0 && v.x == 0 && w.x == 0) || (u.y == 0 && v.y == 0 && w.y == 0) ||
      (u.z == 0 && v.z == 0 && w.z == 0)) {
    return 0;
  }
  return integer_orientation(a, b, c, d);
}

}  // namespace palpate::judge

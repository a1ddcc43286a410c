// Small dense arithmetic of the elastic laws: 3 x 3 matrices by rows.
#pragma once

#include <array>
#include <cstddef>

#include "core/base/types.h"

namespace palpate::dynamics {

/// A 3 x 3 matrix, by rows: entry (i, j) is m[3 i + j].
struct Mat3 {
  std::array<double, 9> m{};

  constexpr double& operator()(std::size_t i, std::size_t j) { return m[3 * i + j]; }
  constexpr double operator()(std::size_t i, std::size_t j) const { return m[3 * i + j]; }
  constexpr Vec3 row(std::size_t i) const { return {m[3 * i], m[3 * i + 1], m[3 * i + 2]}; }

  constexpr Mat3& operator+=(const Mat3& other) {
    for (std::size_t k = 0; k < 9; ++k) m[k] += other.m[k];
    return *this;
  }
  friend constexpr Mat3 operator+(Mat3 a, const Mat3& b) { return a += b; }
  friend constexpr Mat3 operator*(double s, Mat3 a) {
    for (double& entry : a.m) entry *= s;
    return a;
  }
};

/// I.
inline constexpr Mat3 kIdentity{{1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0}};

/// a - b.
constexpr Mat3 operator-(const Mat3& a, const Mat3& b) {
  return a + (-1.0) * b;
}

/// a^T.
constexpr Mat3 transpose(const Mat3& a) {
  return {{a.m[0], a.m[3], a.m[6], a.m[1], a.m[4], a.m[7], a.m[2], a.m[5], a.m[8]}};
}

/// a v.
constexpr Vec3 operator*(const Mat3& a, const Vec3& v) {
  return {dot(a.row(0), v), dot(a.row(1), v), dot(a.row(2), v)};
}

/// a b.
constexpr Mat3 multiply(const Mat3& a, const Mat3& b) {
  Mat3 out;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) out(i, j) = a(i, 0) * b(0, j) + a(i, 1) * b(1, j) + a(i, 2) * b(2, j);
  }
  return out;
}

/// a^T b.
constexpr Mat3 multiply_transposed(const Mat3& a, const Mat3& b) {
  return multiply(transpose(a), b);
}

/// a : b, the sum of the products of the entries.
constexpr double contract(const Mat3& a, const Mat3& b) {
  double sum = 0.0;
  for (std::size_t k = 0; k < 9; ++k) sum += a.m[k] * b.m[k];
  return sum;
}

/// a_11 + a_22 + a_33.
constexpr double trace(const Mat3& a) {
  return a.m[0] + a.m[4] + a.m[8];
}

/// The cofactors: det(a) a^-T.
constexpr Mat3 cofactors(const Mat3& a) {
  const Vec3 x = cross(a.row(1), a.row(2));
  const Vec3 y = cross(a.row(2), a.row(0));
  const Vec3 z = cross(a.row(0), a.row(1));
  return {{x.x, x.y, x.z, y.x, y.y, y.z, z.x, z.y, z.z}};
}

/// det(a), by the first row.
constexpr double determinant(const Mat3& a) {
  return dot(a.row(0), cross(a.row(1), a.row(2)));
}

/// a b^T.
constexpr Mat3 outer(const Vec3& a, const Vec3& b) {
  return {
      {a.x * b.x, a.x * b.y, a.x * b.z, a.y * b.x, a.y * b.y, a.y * b.z, a.z * b.x, a.z * b.y, a.z * b.z}};
}

/// [w]x, the matrix of w x.
constexpr Mat3 cross_matrix(const Vec3& w) {
  return {{0.0, -w.z, w.y, w.z, 0.0, -w.x, -w.y, w.x, 0.0}};
}

/// Adds a b^T to `sum`.
constexpr void add_outer(Mat3& sum, const Vec3& a, const Vec3& b) {
  sum += outer(a, b);
}

}  // namespace palpate::dynamics

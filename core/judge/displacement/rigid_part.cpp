#include "core/judge/displacement/rigid_part.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/error.h"
#include "core/judge/mesh/compensated_sum.h"

namespace palpate::judge {
namespace {

/// Below this share of the largest, a principal moment of inertia is zero: its axis turns nothing.
constexpr double kNoInertia = 1e-13;

using Matrix = std::array<std::array<double, 3>, 3>;

/// Sums of vectors without loss.
class VectorSum {
 public:
  void add(const Vec3& v) {
    x_.add(v.x);
    y_.add(v.y);
    z_.add(v.z);
  }
  Vec3 value() const { return {x_.value(), y_.value(), z_.value()}; }

 private:
  CompensatedSum x_;
  CompensatedSum y_;
  CompensatedSum z_;
};

/// Turns a symmetric matrix into its eigenvalues on the diagonal, by Jacobi's rotations, and returns the
/// eigenvectors as columns.
Matrix diagonalise(Matrix& a) {
  Matrix vectors{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  for (int sweep = 0; sweep < 30; ++sweep) {
    for (std::size_t p = 0; p < 2; ++p) {
      for (std::size_t q = p + 1; q < 3; ++q) {
        if (a[p][q] == 0.0) continue;
        const double theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
        const double t = (theta >= 0.0 ? 1.0 : -1.0) / (std::fabs(theta) + std::hypot(theta, 1.0));
        const double c = 1.0 / std::hypot(t, 1.0);
        const double s = t * c;
        for (std::size_t k = 0; k < 3; ++k) {
          const double kp = a[k][p];
          const double kq = a[k][q];
          a[k][p] = c * kp - s * kq;
          a[k][q] = s * kp + c * kq;
        }
        for (std::size_t k = 0; k < 3; ++k) {
          const double pk = a[p][k];
          const double qk = a[q][k];
          a[p][k] = c * pk - s * qk;
          a[q][k] = s * pk + c * qk;
        }
        for (auto& row : vectors) {
          const double vp = row[p];
          const double vq = row[q];
          row[p] = c * vp - s * vq;
          row[q] = s * vp + c * vq;
        }
      }
    }
  }
  return vectors;
}

/// The least omega with J omega = turning.
Vec3 solve_rotation(Matrix inertia, const Vec3& turning) {
  const Matrix axes = diagonalise(inertia);
  double largest = 0.0;
  for (std::size_t k = 0; k < 3; ++k) largest = std::max(largest, inertia[k][k]);
  Vec3 omega;
  for (std::size_t k = 0; k < 3; ++k) {
    if (!(inertia[k][k] > kNoInertia * largest)) continue;
    const Vec3 axis{axes[0][k], axes[1][k], axes[2][k]};
    omega = omega + (dot(axis, turning) / inertia[k][k]) * axis;
  }
  return omega;
}

Matrix inertia_of(std::span<const Vec3> points, std::span<const double> weight, const Vec3& center) {
  std::array<CompensatedSum, 6> sum;  // xx, yy, zz, xy, yz, zx of w q q^T
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3 q = points[i] - center;
    const std::array<double, 6> product{q.x * q.x, q.y * q.y, q.z * q.z, q.x * q.y, q.y * q.z, q.z * q.x};
    for (std::size_t k = 0; k < product.size(); ++k) sum[k].add(weight[i] * product[k]);
  }
  const double xx = sum[0].value();
  const double yy = sum[1].value();
  const double zz = sum[2].value();
  const double xy = -sum[3].value();
  const double yz = -sum[4].value();
  const double zx = -sum[5].value();
  return {{{yy + zz, xy, zx}, {xy, zz + xx, yz}, {zx, yz, xx + yy}}};
}

}  // namespace

std::vector<Vec3> without_rigid_motion(std::span<const Vec3> points, std::span<const double> weight,
                                       std::span<const Vec3> field) {
  require(points.size() == field.size() && weight.size() == field.size(),
          "without_rigid_motion: sizes differ");
  CompensatedSum whole;
  VectorSum place;
  VectorSum move;
  for (std::size_t i = 0; i < field.size(); ++i) {
    whole.add(weight[i]);
    place.add(weight[i] * points[i]);
    move.add(weight[i] * field[i]);
  }
  if (!(whole.value() > 0.0)) return {field.begin(), field.end()};
  const Vec3 center = (1.0 / whole.value()) * place.value();
  const Vec3 translation = (1.0 / whole.value()) * move.value();
  VectorSum turning;
  for (std::size_t i = 0; i < field.size(); ++i)
    turning.add(weight[i] * cross(points[i] - center, field[i] - translation));
  const Vec3 omega = solve_rotation(inertia_of(points, weight, center), turning.value());
  std::vector<Vec3> rest(field.size());
  for (std::size_t i = 0; i < field.size(); ++i)
    rest[i] = field[i] - translation - cross(omega, points[i] - center);
  return rest;
}

}  // namespace palpate::judge

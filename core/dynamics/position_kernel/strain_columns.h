// The six strains of a gradient, and how vertices change them.
#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <cstddef>
#include <span>

#include "core/dynamics/elasticity/elastic_law.h"
#include "core/dynamics/elasticity/strain_operator.h"

namespace palpate::dynamics {

/// Six strains.
using Vector6 = Eigen::Matrix<double, 6, 1>;
/// A map of six strains.
using Matrix6 = Eigen::Matrix<double, 6, 6>;
/// Three components of a vertex for each of six strains.
using Matrix36 = Eigen::Matrix<double, 3, 6>;

/// Strains xx, yy, zz, 2 yz, 2 xz, 2 xy of the symmetric part of a matrix.
inline Vector6 strains_of(const Mat3& a) {
  Vector6 out;
  out << a(0, 0), a(1, 1), a(2, 2), a(1, 2) + a(2, 1), a(0, 2) + a(2, 0), a(0, 1) + a(1, 0);
  return out;
}

/// The matrix T with T g = sum over the strains of l times their gradient at a vertex with shape gradient g.
inline Mat3 stress_of(const Vector6& l) {
  return {{l[0], l[5], l[4], l[5], l[1], l[3], l[4], l[3], l[2]}};
}

/// Column a is the gradient of strain a at a vertex with shape gradient g.
inline Matrix36 strain_gradients(const Vec3& g) {
  Matrix36 out;
  out << g.x, 0.0, 0.0, 0.0, g.z, g.y,  //
      0.0, g.y, 0.0, g.z, 0.0, g.x,     //
      0.0, 0.0, g.z, g.y, g.x, 0.0;
  return out;
}

/// V (lambda, mu) of the six strains, in J.
inline Matrix6 strain_stiffness(const Moduli& moduli, double volume_m3) {
  Matrix6 out = Matrix6::Zero();
  out.topLeftCorner<3, 3>().setConstant(volume_m3 * moduli.lambda_pa);
  for (int k = 0; k < 3; ++k) {
    out(k, k) += 2.0 * volume_m3 * moduli.mu_pa;
    out(3 + k, 3 + k) = volume_m3 * moduli.mu_pa;
  }
  return out;
}

/// (1 + factor K G)^-1 of a domain whose strains are those of sym(frame^T H): what corrects their
/// multipliers all at once. G = sum over its vertices of their gradients, weighed by the inverse masses.
inline Matrix6 strain_correction(const StrainOperator& op, std::size_t domain, const Moduli& moduli,
                                 const Mat3& frame, std::span<const Vec3> inverse_mass, double factor) {
  Matrix6 g = Matrix6::Zero();
  using Rows3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  const Eigen::Map<const Rows3> turn(frame.m.data());
  for (Index k = op.offsets[domain]; k < op.offsets[domain + 1]; ++k) {
    const Vec3& w = inverse_mass[op.vertices[k]];
    const Matrix36 gradients = turn * strain_gradients(op.gradients[k]);
    g += gradients.transpose() * Eigen::Vector3d(w.x, w.y, w.z).asDiagonal() * gradients;
  }
  const Matrix6 system = Matrix6::Identity() + factor * strain_stiffness(moduli, op.volume_m3[domain]) * g;
  return system.partialPivLu().inverse();
}

}  // namespace palpate::dynamics

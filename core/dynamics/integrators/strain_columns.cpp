#include "core/dynamics/integrators/strain_columns.h"

#include <Eigen/LU>

namespace palpate::dynamics {

Matrix6 strain_correction(const StrainOperator& op, std::size_t domain, const Moduli& moduli,
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

#include "core/dynamics/integrators/neo_hookean_constraints.h"

#include <algorithm>
#include <string>

#include "core/base/error.h"
#include "core/dynamics/integrators/strain_columns.h"

namespace palpate::dynamics {
namespace {

Vec3 times_axes(const Vec3& a, const Vec3& b) {
  return {a.x * b.x, a.y * b.y, a.z * b.z};
}

/// det(I + h) - 1 without cancellation.
double change_of_volume(const Mat3& h) {
  return trace(h) + trace(cofactors(h)) + determinant(h);
}

}  // namespace

GradientConstraint hydrostatic_constraint(const Moduli& moduli, const Mat3& h) {
  const double bulk = moduli.lambda_pa + moduli.mu_pa;
  return {change_of_volume(h) - moduli.mu_pa / bulk, cofactors(kIdentity + h)};
}

NeoHookeanConstraints::NeoHookeanConstraints(const StrainTerm& term)
    : term_(&term), bulk_pa_(term.moduli.lambda_pa + term.moduli.mu_pa) {
  if (!(term.moduli.mu_pa >= 0.0 && bulk_pa_ > 0.0))
    throw InputError("integrator", 0, "mu of 0 or more and lambda + mu above 0 for xpbd",
                     std::to_string(term.moduli.mu_pa) + " and " + std::to_string(bulk_pa_) + " Pa");
}

void NeoHookeanConstraints::weigh() {
  const StrainOperator& op = term_->op;
  const bool is_mixed = std::any_of(inverse_mass_.begin(), inverse_mass_.end(),
                                    [](const Vec3& w) { return w.x != w.y || w.y != w.z; });
  axes_ = is_mixed ? 3 : 1;
  weights_.resize(axes_ * size());
  for (std::size_t s = 0; s < size(); ++s) {
    for (std::size_t axis = 0; axis < axes_; ++axis) {
      Mat3 a;
      for (Index k = op.offsets[s]; k < op.offsets[s + 1]; ++k) {
        const Vec3& w = inverse_mass_[op.vertices[k]];
        a += (axis == 0 ? w.x : (axis == 1 ? w.y : w.z)) * outer(op.gradients[k], op.gradients[k]);
      }
      const Mat3 system = kIdentity + (2.0 * step_s_ * step_s_ * op.volume_m3[s] * term_->moduli.mu_pa) * a;
      Weights& weights = weights_[axes_ * s + axis];
      weights.m = (1.0 / determinant(system)) * cofactors(system);
      weights.ma = multiply(weights.m, a);
    }
  }
}

void NeoHookeanConstraints::start(double step_s, double damping_s, std::span<const Vec3> before,
                                  std::span<const Vec3> inverse_mass) {
  const StrainOperator& op = term_->op;
  inverse_mass_ = inverse_mass;
  damping_s_ = damping_s;
  if (step_s != step_s_) {
    step_s_ = step_s;
    weigh();
  }
  shape_.assign(size(), {});
  volume_.assign(size(), 0.0);
  pulled_.assign(size(), {});
  if (damping_s == 0.0) return;
  frame_.resize(size());
  damping_multiplier_.assign(size(), {});
  damping_correction_.resize(size());
  for (std::size_t s = 0; s < size(); ++s) {
    frame_[s] = kIdentity + displacement_gradient(op, s, before);
    Eigen::Map<Matrix6>(damping_correction_[s].data()) =
        strain_correction(op, s, term_->moduli, frame_[s], inverse_mass, step_s * damping_s);
  }
}

/// a M or a M A, row by row where axes differ.
Mat3 NeoHookeanConstraints::times(std::size_t s, const Mat3& a, Mat3 Weights::*by) const {
  if (axes_ == 1) return multiply(a, weights_[s].*by);
  Mat3 out;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Vec3 row = (weights_[3 * s + axis].*by) * a.row(axis);
    out(axis, 0) = row.x;
    out(axis, 1) = row.y;
    out(axis, 2) = row.z;
  }
  return out;
}

void NeoHookeanConstraints::move(std::size_t s, const Mat3& pull, std::span<Vec3> u) const {
  const StrainOperator& op = term_->op;
  for (Index k = op.offsets[s]; k < op.offsets[s + 1]; ++k) {
    const Index v = op.vertices[k];
    u[v] = u[v] + times_axes(inverse_mass_[v], pull * op.gradients[k]);
  }
}

void NeoHookeanConstraints::damp(std::size_t s, std::span<Vec3> u) {
  const StrainOperator& op = term_->op;
  const Mat3 since = kIdentity + displacement_gradient(op, s, u) - frame_[s];
  Eigen::Map<Vector6> multiplier(damping_multiplier_[s].data());
  const Vector6 off =
      multiplier + (step_s_ * damping_s_) * (strain_stiffness(term_->moduli, op.volume_m3[s]) *
                                             strains_of(multiply_transposed(frame_[s], since)));
  const Vector6 change = -(Eigen::Map<const Matrix6>(damping_correction_[s].data()) * off);
  multiplier += change;
  move(s, multiply(frame_[s], stress_of(change)), u);
}

void NeoHookeanConstraints::solve(std::size_t s, std::span<Vec3> u) {
  if (damping_s_ != 0.0) damp(s, u);
  const Mat3 h = displacement_gradient(term_->op, s, u);
  const double scale = step_s_ * step_s_ * term_->op.volume_m3[s];
  const double stiffness = scale * bulk_pa_;
  const GradientConstraint volume = hydrostatic_constraint(term_->moduli, h);
  double& l = volume_[s];
  Mat3& pulled = pulled_[s];
  const Mat3 off =
      (l * volume.slope - pulled) - (shape_[s] + (scale * term_->moduli.mu_pa) * (kIdentity + h));
  const double change =
      -(l + stiffness * (volume.value + contract(volume.slope, times(s, off, &Weights::ma)))) /
      (1.0 + stiffness * contract(volume.slope, times(s, volume.slope, &Weights::ma)));
  const Mat3 pull = times(s, off + change * volume.slope, &Weights::m);
  l += change;
  const Mat3 by_volume = l * volume.slope;
  shape_[s] += pull - (by_volume - pulled);
  pulled = by_volume;
  move(s, pull, u);
}

}  // namespace palpate::dynamics

#include "core/dynamics/integrators/neo_hookean_constraints.h"

#include <algorithm>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "core/dynamics/position_kernel/strain_columns.h"

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

NeoHookeanConstraints::NeoHookeanConstraints(const StrainTerm& term, std::vector<Index> domains)
    : term_(&term), domains_(std::move(domains)), bulk_pa_(term.moduli.lambda_pa + term.moduli.mu_pa) {
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
  for (std::size_t place = 0; place < size(); ++place) {
    const Index s = domains_[place];
    for (std::size_t axis = 0; axis < axes_; ++axis) {
      Mat3 a;
      for (Index k = op.offsets[s]; k < op.offsets[s + 1]; ++k) {
        const Vec3& w = inverse_mass_[op.vertices[k]];
        a += (axis == 0 ? w.x : (axis == 1 ? w.y : w.z)) * outer(op.gradients[k], op.gradients[k]);
      }
      const Mat3 system = kIdentity + (2.0 * step_s_ * step_s_ * op.volume_m3[s] * term_->moduli.mu_pa) * a;
      Weights& weights = weights_[axes_ * place + axis];
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
  for (std::size_t k = 0; k < size(); ++k) {
    frame_[k] = kIdentity + displacement_gradient(op, domains_[k], before);
    Eigen::Map<Matrix6>(damping_correction_[k].data()) =
        strain_correction(op, domains_[k], term_->moduli, frame_[k], inverse_mass, step_s * damping_s);
  }
}

/// a M or a M A, row by row where axes differ.
Mat3 NeoHookeanConstraints::times(std::size_t k, const Mat3& a, Mat3 Weights::*by) const {
  if (axes_ == 1) return multiply(a, weights_[k].*by);
  Mat3 out;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Vec3 row = (weights_[3 * k + axis].*by) * a.row(axis);
    out(axis, 0) = row.x;
    out(axis, 1) = row.y;
    out(axis, 2) = row.z;
  }
  return out;
}

void NeoHookeanConstraints::move(std::size_t k, const Mat3& pull, PositionRows& rows) const {
  const StrainOperator& op = term_->op;
  const Index s = domains_[k];
  for (Index i = op.offsets[s]; i < op.offsets[s + 1]; ++i) {
    const Index v = op.vertices[i];
    set_row(rows, v, row_of(rows, v) + times_axes(inverse_mass_[v], pull * op.gradients[i]));
  }
}

void NeoHookeanConstraints::damp(std::size_t k, PositionRows& rows) {
  const StrainOperator& op = term_->op;
  const Index s = domains_[k];
  const Mat3 since = kIdentity + gradient_of_rows(op, s, rows) - frame_[k];
  Eigen::Map<Vector6> multiplier(damping_multiplier_[k].data());
  const Vector6 off =
      multiplier + (step_s_ * damping_s_) * (strain_stiffness(term_->moduli, op.volume_m3[s]) *
                                             strains_of(multiply_transposed(frame_[k], since)));
  const Vector6 change = -(Eigen::Map<const Matrix6>(damping_correction_[k].data()) * off);
  multiplier += change;
  move(k, multiply(frame_[k], stress_of(change)), rows);
}

void NeoHookeanConstraints::solve(std::size_t k, PositionRows& rows) {
  if (damping_s_ != 0.0) damp(k, rows);
  const Index s = domains_[k];
  const Mat3 h = gradient_of_rows(term_->op, s, rows);
  const double scale = step_s_ * step_s_ * term_->op.volume_m3[s];
  const double stiffness = scale * bulk_pa_;
  const GradientConstraint volume = hydrostatic_constraint(term_->moduli, h);
  double& l = volume_[k];
  Mat3& pulled = pulled_[k];
  const Mat3 off =
      (l * volume.slope - pulled) - (shape_[k] + (scale * term_->moduli.mu_pa) * (kIdentity + h));
  const double change =
      -(l + stiffness * (volume.value + contract(volume.slope, times(k, off, &Weights::ma)))) /
      (1.0 + stiffness * contract(volume.slope, times(k, volume.slope, &Weights::ma)));
  const Mat3 pull = times(k, off + change * volume.slope, &Weights::m);
  l += change;
  const Mat3 by_volume = l * volume.slope;
  shape_[k] += pull - (by_volume - pulled);
  pulled = by_volume;
  move(k, pull, rows);
}

}  // namespace palpate::dynamics

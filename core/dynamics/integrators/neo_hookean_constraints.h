// XPBD's constraints of a stable neo-Hookean energy: one of shape and one of volume a domain.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "core/dynamics/elasticity/elastic_model.h"
#include "core/dynamics/position_kernel/position_rows.h"

namespace palpate::dynamics {

/// A scalar constraint of a deformation gradient.
struct GradientConstraint {
  double value = 0.0;
  Mat3 slope;  ///< by F
};

/// C_H = det F - 1 - mu / (lambda + mu). Requires: lambda + mu above zero.
GradientConstraint hydrostatic_constraint(const Moduli& moduli, const Mat3& h);

/// The constraints of domains of one term of the law kStableNeoHookean, one at a time. Up to a constant
///
///   V W = 1/2 V mu C_D^2 + 1/2 V (lambda + mu) C_H^2,   C_D = |F|,   C_H = J - 1 - mu / (lambda + mu)
///
/// so that both have the compliances of a material. At rest neither vanishes: their forces balance. The slope
/// of |F| is there that of the volume: taken as one number, C_D leaves a shear to be pulled as by an explicit
/// step. So it is taken as the vector F, whose length it is, with nine multipliers L and a constant slope.
/// Both are solved at once, with A = sum of W g g^T over the domain's vertices, S the slope of C_H, and k =
/// h^2 V mu:
///
///   M = (I + 2 k A)^-1,  T = l S - what C_H has pulled in this step,
///   dl = -(l + k_H (C_H + S : (T - L - k F) M A)) / (1 + k_H S : S M A),   k_H = h^2 V (lambda + mu)
///   pull = (T + dl S - L - k F) M,   u += W pull g
///
/// A shear meets k from F and k from the turning of S; hence 2 k, with which a solve goes no farther than the
/// shear. T, which is not in the source, takes back what was pulled along the earlier slopes of C_H, so that
/// sweeps converge to backward Euler's step. Without damping, that is: the damping of the law takes six
/// multipliers about the gradient at the start of the step, where backward Euler has the one at its end.
///
/// Source: M. Macklin and M. Mueller, A constraint-based formulation of stable neo-Hookean materials, MIG
/// 2021.
class NeoHookeanConstraints {
 public:
  /// Of the term's `domains`, in their order. `term` must outlive this. Throws: InputError where mu is
  /// negative or lambda + mu not above zero.
  NeoHookeanConstraints(const StrainTerm& term, std::vector<Index> domains);

  /// How many domains there are.
  std::size_t size() const { return domains_.size(); }

  /// Begins a step of length `step_s` from the displacements `before`: no multiplier, and the damping of
  /// `damping_s` x the moduli with the gradients of now. `inverse_mass` (1/kg along each axis) must outlive
  /// the step, and may only change where the step's length does.
  void start(double step_s, double damping_s, std::span<const Vec3> before,
             std::span<const Vec3> inverse_mass);

  /// Solves the domain at place `k` for its own multipliers and moves its vertices.
  void solve(std::size_t k, PositionRows& rows);

 private:
  /// Of one domain and axis. Symmetric, and they commute.
  struct Weights {
    Mat3 m;   ///< M
    Mat3 ma;  ///< M A
  };

  void weigh();
  Mat3 times(std::size_t k, const Mat3& a, Mat3 Weights::*by) const;
  void damp(std::size_t k, PositionRows& rows);
  void move(std::size_t k, const Mat3& pull, PositionRows& rows) const;

  const StrainTerm* term_;
  std::vector<Index> domains_;
  double bulk_pa_;  ///< lambda + mu
  double step_s_ = 0.0;
  double damping_s_ = 0.0;
  std::span<const Vec3> inverse_mass_;
  std::size_t axes_ =
      1;  ///< 3 where a vertex is held along some axes alone, so that each has its own weights
  std::vector<Weights> weights_;
  std::vector<Mat3> shape_;     ///< L
  std::vector<double> volume_;  ///< l
  std::vector<Mat3> pulled_;    ///< by C_H
  std::vector<Mat3> frame_;     ///< F at the start of the step
  std::vector<std::array<double, 6>> damping_multiplier_;
  std::vector<std::array<double, 36>> damping_correction_;
};

}  // namespace palpate::dynamics

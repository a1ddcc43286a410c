// The slowest rates of a damped body at rest: how long it takes to come back.
#pragma once

#include <complex>
#include <vector>

#include "core/dynamics/motion/motion_model.h"

namespace palpate::dynamics {

/// Roots of lambda^2 M x + lambda D x + K x = 0: small motions about rest go as exp(lambda t).
struct SlowRates {
  std::vector<std::complex<double>> lambda_per_s;  ///< those nearest to zero, nearest first
  std::size_t solves = 0;                          ///< with K
  bool converged = false;

  /// The longest time in which one of these motions falls to 1/e, -1 / Re lambda; infinity if one does not
  /// fall. Requires: converged.
  double slowest_decay_s() const;
};

/// The roots nearest to zero, at most `count` and as many as there are components: Arnoldi's method (Spectra)
/// on (x, s v) with the inverse, which solves with K: by a sparse factorisation up to 4000 vertices, by
/// conjugate gradients beyond. Supports and held components are there; the thesis's volume force, K - k d g^T
/// (volume_force.h), by the formula of Sherman and Morrison. Deterministic for any number of threads.
/// Throws: as validate(MotionModel); InputError for a body that is not held against every rigid motion, or
/// that is not stiff in all directions.
SlowRates find_slow_rates(const MotionModel& model, std::size_t count = 6, int threads = 1);

}  // namespace palpate::dynamics

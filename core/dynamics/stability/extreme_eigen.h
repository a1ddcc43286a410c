// The largest eigenvalue of a symmetric block matrix.
#pragma once

#include <complex>
#include <vector>

#include "core/dynamics/linear_algebra/block_matrix.h"

namespace palpate::dynamics {

/// The algebraically largest eigenvalue with its vector of length 1.
struct ExtremeEigen {
  double value = 0.0;
  std::vector<Vec3> vector;
  std::size_t products = 0;
  bool converged = false;
};

/// By Spectra's restarted Lanczos method, to a residual of 1e-4 of the value; where that breaks down or its
/// answer is none, as it does for matrices of few different eigenvalues (a drag that is the same multiple of
/// all masses), by a plain Lanczos method that takes a breakdown for its end. Deterministic for any number of
/// threads. Requires: at least one row.
ExtremeEigen find_largest_eigenvalue(const BlockMatrix& matrix, int threads);

/// The eigenvalues of largest size of lambda^2 x + lambda D x + K x = 0.
struct FastestRates {
  std::vector<std::complex<double>> lambda;
  std::size_t products = 0;
  bool converged = false;
};

/// At most eight of them, by Spectra's restarted Arnoldi method on (s x, x'), s^2 = `stiffness_max`.
/// Requires: both with the same rows, at least one; stiffness_max > 0.
FastestRates find_fastest_rates(const BlockMatrix& stiffness, const BlockMatrix& damping,
                                double stiffness_max, int threads);

/// All of them, of the components that have stiffness or damping, by Eigen's dense QR method. The time grows
/// with the third power of the rows. Requires: both of one pattern, at least one row.
FastestRates find_all_rates(const BlockMatrix& stiffness, const BlockMatrix& damping);

}  // namespace palpate::dynamics

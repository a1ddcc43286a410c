// The largest eigenvalue of a symmetric block matrix.
#pragma once

#include <complex>
#include <span>
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

/// By Lanczos's method without restarts, to a residual of 1e-4 of the value: two runs of its recurrence, one
/// for the value and one for the vector, in the memory of three vectors. Where its answer is none, by a
/// hundred vectors that are kept orthogonal. `guess`: a vector that is likely near, such as that of a similar
/// matrix; empty for none. Deterministic for any number of threads. Requires: at least one row; a guess of
/// that shape. Source: C. Lanczos, J. Res. Nat. Bur. Standards 45 (1950), 255-282; J. Cullum and R. A.
/// Willoughby, Lanczos Algorithms for Large Symmetric Eigenvalue Computations (1985).
ExtremeEigen find_largest_eigenvalue(const BlockMatrix& matrix, int threads,
                                     std::span<const Vec3> guess = {});

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

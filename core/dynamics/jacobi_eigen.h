// Eigenvalues and vectors of small symmetric matrices by Jacobi's rotations.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace palpate::dynamics {

/// A symmetric N x N matrix as V diag(values) V^T; vector k is column k: vectors[N i + k]. Not sorted.
template <std::size_t N>
struct SymmetricEigen {
  std::array<double, N> values{};
  std::array<double, N * N> vectors{};
};

/// Cyclic Jacobi rotations until what is off the diagonal is below rounding: each angle is the one that makes
/// entry (p, q) vanish. Accurate to a few units of rounding of the largest entry.
/// Source: G. Golub and C. Van Loan, Matrix Computations, section 8.5.
template <std::size_t N>
SymmetricEigen<N> decompose_symmetric(std::array<double, N * N> a) {
  SymmetricEigen<N> out;
  auto& v = out.vectors;
  for (std::size_t i = 0; i < N; ++i) v[N * i + i] = 1.0;
  const auto rotate = [](double& x, double& y, double c, double s) {
    const double old = x;
    x = c * old - s * y;
    y = s * old + c * y;
  };
  constexpr int kMostSweeps = 60;
  for (int sweep = 0; sweep < kMostSweeps; ++sweep) {
    double off = 0.0;
    double all = 0.0;
    for (std::size_t i = 0; i < N; ++i) {
      for (std::size_t j = 0; j < N; ++j) (i == j ? all : off) += a[N * i + j] * a[N * i + j];
    }
    if (off <= 1e-32 * (all + off)) break;
    for (std::size_t p = 0; p + 1 < N; ++p) {
      for (std::size_t q = p + 1; q < N; ++q) {
        const double entry = a[N * p + q];
        if (entry == 0.0) continue;
        const double tau = (a[N * q + q] - a[N * p + p]) / (2.0 * entry);
        const double t = (tau >= 0.0 ? 1.0 : -1.0) / (std::abs(tau) + std::hypot(1.0, tau));
        const double c = 1.0 / std::hypot(1.0, t);
        const double s = t * c;
        for (std::size_t k = 0; k < N; ++k) rotate(a[N * k + p], a[N * k + q], c, s);
        for (std::size_t k = 0; k < N; ++k) rotate(a[N * p + k], a[N * q + k], c, s);
        for (std::size_t k = 0; k < N; ++k) rotate(v[N * k + p], v[N * k + q], c, s);
      }
    }
  }
  for (std::size_t i = 0; i < N; ++i) out.values[i] = a[N * i + i];
  return out;
}

}  // namespace palpate::dynamics

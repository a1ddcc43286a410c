// A false alarm of g++ 12 inside Eigen, from what Spectra's Arnoldi method frees and allocates in a loop.
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wuse-after-free"
#endif

#include "core/dynamics/extreme_eigen.h"

#include <Spectra/GenEigsSolver.h>
#include <Spectra/SymEigsSolver.h>
#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/base/error.h"

namespace palpate::dynamics {
namespace {

/// What Spectra asks of a matrix.
class Product {
 public:
  using Scalar = double;  // NOLINT(readability-identifier-naming): Spectra's name

  Product(const BlockMatrix& matrix, int threads)
      : matrix_(&matrix), threads_(threads), in_(matrix.rows()), out_(matrix.rows()) {}

  Eigen::Index rows() const { return static_cast<Eigen::Index>(3 * matrix_->rows()); }
  Eigen::Index cols() const { return rows(); }

  void perform_op(const double* x, double* y) const {
    for (std::size_t v = 0; v < in_.size(); ++v) in_[v] = {x[3 * v], x[3 * v + 1], x[3 * v + 2]};
    multiply(*matrix_, in_, out_, threads_);
    for (std::size_t v = 0; v < out_.size(); ++v) {
      y[3 * v] = out_[v].x;
      y[3 * v + 1] = out_[v].y;
      y[3 * v + 2] = out_[v].z;
    }
  }

 private:
  const BlockMatrix* matrix_;
  int threads_;
  mutable std::vector<Vec3> in_;
  mutable std::vector<Vec3> out_;
};

/// (s x, v) -> (s v, -K x - D v).
class RateProduct {
 public:
  using Scalar = double;  // NOLINT(readability-identifier-naming): Spectra's name

  RateProduct(const BlockMatrix& stiffness, const BlockMatrix& damping, double scale, int threads)
      : stiffness_(stiffness, threads), damping_(damping, threads), scale_(scale), work_(stiffness_.rows()) {}

  Eigen::Index rows() const { return 2 * stiffness_.rows(); }
  Eigen::Index cols() const { return rows(); }

  void perform_op(const double* x, double* y) const {
    const Eigen::Index n = stiffness_.rows();
    stiffness_.perform_op(x, y + n);
    damping_.perform_op(x + n, work_.data());
    for (Eigen::Index k = 0; k < n; ++k) {
      y[n + k] = -y[n + k] / scale_ - work_[k];
      y[k] = scale_ * x[n + k];
    }
  }

 private:
  Product stiffness_;
  Product damping_;
  double scale_;
  mutable Eigen::VectorXd work_;
};

}  // namespace

FastestRates find_fastest_rates(const BlockMatrix& stiffness, const BlockMatrix& damping,
                                double stiffness_max, int threads) {
  require(stiffness.rows() > 0 && damping.rows() == stiffness.rows() && stiffness_max > 0.0,
          "two matrices of the same rows, and a scale");
  RateProduct product(stiffness, damping, std::sqrt(stiffness_max), threads);
  const Eigen::Index wanted = std::min<Eigen::Index>(8, product.rows() - 2);
  const Eigen::Index most_vectors = 40;
  constexpr Eigen::Index kRestarts = 200;
  constexpr double kTolerance = 1e-4;
  Spectra::GenEigsSolver<RateProduct> solver(product, wanted, std::min(most_vectors, product.rows()));
  solver.init();
  solver.compute(Spectra::SortRule::LargestMagn, kRestarts, kTolerance);
  FastestRates out;
  out.products = static_cast<std::size_t>(solver.num_operations());
  out.converged = solver.info() == Spectra::CompInfo::Successful;
  const auto values = solver.eigenvalues();
  for (Eigen::Index k = 0; k < values.size(); ++k) out.lambda.push_back(values[k]);
  return out;
}

FastestRates find_all_rates(const BlockMatrix& stiffness, const BlockMatrix& damping) {
  require(stiffness.rows() > 0 && damping.columns == stiffness.columns, "two matrices of one pattern");
  std::vector<Eigen::Index> number(3 * stiffness.rows(), -1);
  Eigen::Index count = 0;
  const auto for_each = [&](const auto& visit) {
    for (std::size_t v = 0; v < stiffness.rows(); ++v) {
      for (std::size_t k = stiffness.offsets[v]; k < stiffness.offsets[v + 1]; ++k) {
        for (std::size_t i = 0; i < 9; ++i)
          visit(3 * v + i / 3, 3 * std::size_t{stiffness.columns[k]} + i % 3,
                stiffness.blocks[k](i / 3, i % 3), damping.blocks[k](i / 3, i % 3));
      }
    }
  };
  double scale = 0.0;
  for_each([&](std::size_t row, std::size_t, double k, double d) {
    if ((k != 0.0 || d != 0.0) && number[row] < 0) number[row] = count++;
    scale = std::max({scale, std::sqrt(std::abs(k)), std::abs(d)});
  });
  FastestRates out;
  out.converged = true;
  if (count == 0) return out;
  Eigen::MatrixXd rates = Eigen::MatrixXd::Zero(2 * count, 2 * count);
  for (Eigen::Index k = 0; k < count; ++k) rates(k, count + k) = 1.0;
  for_each([&](std::size_t row, std::size_t column, double k, double d) {
    if (number[row] < 0 || number[column] < 0) return;
    rates(count + number[row], number[column]) = -k / (scale * scale);
    rates(count + number[row], count + number[column]) = -d / scale;
  });
  const Eigen::EigenSolver<Eigen::MatrixXd> solver(rates, false);
  out.converged = solver.info() == Eigen::Success;
  const auto& values = solver.eigenvalues();
  for (Eigen::Index k = 0; out.converged && k < values.size(); ++k) out.lambda.push_back(scale * values[k]);
  return out;
}

namespace {

/// The power method, for a symmetric semidefinite matrix of few different eigenvalues.
ExtremeEigen iterate_powers(const Product& product, double tolerance) {
  constexpr std::size_t kMostProducts = 1000;
  const Eigen::Index n = product.rows();
  Eigen::VectorXd x(n);
  for (Eigen::Index k = 0; k < n; ++k) x[k] = 1.0 + 0.5 * std::sin(static_cast<double>(k + 1));
  Eigen::VectorXd y(n);
  ExtremeEigen out;
  for (; out.products < kMostProducts && !out.converged; ++out.products) {
    x.normalize();
    product.perform_op(x.data(), y.data());
    out.value = x.dot(y);
    out.converged = (y - out.value * x).norm() <= tolerance * std::abs(out.value);
    if (!out.converged) x = y;
  }
  for (Eigen::Index k = 0; k < n; k += 3) out.vector.push_back({x[k], x[k + 1], x[k + 2]});
  return out;
}

}  // namespace

ExtremeEigen find_largest_eigenvalue(const BlockMatrix& matrix, int threads) {
  require(matrix.rows() > 0, "at least one row");
  Product product(matrix, threads);
  const Eigen::Index most_vectors = 30;
  constexpr Eigen::Index kRestarts = 100;
  constexpr double kTolerance = 1e-4;
  Spectra::SymEigsSolver<Product> solver(product, 1, std::min(most_vectors, product.rows()));
  ExtremeEigen out;
  try {
    solver.init();
    solver.compute(Spectra::SortRule::LargestAlge, kRestarts, kTolerance);
  } catch (const std::runtime_error&) {  // Krylov's space ended: a multiple of the identity, say
    return iterate_powers(product, kTolerance);
  }
  out.products = static_cast<std::size_t>(solver.num_operations());
  out.converged = solver.info() == Spectra::CompInfo::Successful;
  if (!out.converged) return out;
  out.value = solver.eigenvalues()[0];
  const Eigen::VectorXd vector = solver.eigenvectors().col(0);
  out.vector.resize(matrix.rows());
  for (std::size_t v = 0; v < out.vector.size(); ++v) {
    const auto at = static_cast<Eigen::Index>(3 * v);
    out.vector[v] = {vector[at], vector[at + 1], vector[at + 2]};
  }
  return out;
}

}  // namespace palpate::dynamics

// A false alarm of g++ 12 inside Eigen, from what Spectra's Arnoldi method frees and allocates in a loop.
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wuse-after-free"
#endif

#include "core/dynamics/stability/extreme_eigen.h"

#include <Spectra/GenEigsSolver.h>
#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "core/base/component.h"
#include "core/base/error.h"
#include "core/base/random.h"
#include "core/dynamics/linear_algebra/signed_index.h"
#include "core/dynamics/linear_algebra/vertex_field.h"

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

std::vector<Vec3> to_field(const Eigen::VectorXd& x) {
  std::vector<Vec3> field(static_cast<std::size_t>(x.size() / 3));
  for (std::size_t v = 0; v < field.size(); ++v) {
    const auto at = static_cast<Eigen::Index>(3 * v);
    field[v] = {x[at], x[at + 1], x[at + 2]};
  }
  return field;
}

constexpr double kTolerance = 1e-4;

/// Whether a value and a vector are what they are said to be.
bool is_eigenpair(const Product& product, double value, const Eigen::VectorXd& vector) {
  constexpr double kUnit = 1e-6;
  if (!std::isfinite(value) || !(std::abs(vector.norm() - 1.0) <= kUnit)) return false;
  Eigen::VectorXd image(vector.size());
  product.perform_op(vector.data(), image.data());
  return (image - value * vector).norm() <= 10.0 * kTolerance * std::abs(value);
}

/// Lanczos's method with full orthogonalisation from a seeded vector. A seeded vector has a part of every
/// eigenvector, so where the vectors it makes come to an end they hold all different eigenvalues.
ExtremeEigen find_by_plain_lanczos(const Product& product) {
  const Eigen::Index n = product.rows();
  const Eigen::Index most = std::min<Eigen::Index>(n, 100);
  constexpr double kEnd = 1e-10;
  Eigen::MatrixXd basis(n, most);
  Eigen::MatrixXd small = Eigen::MatrixXd::Zero(most, most);
  SplitMix64 random(1);
  Eigen::VectorXd next(n);
  for (Eigen::Index k = 0; k < n; ++k) next[k] = random.uniform() - 0.5;
  next.normalize();
  Eigen::Index count = 0;
  bool is_closed = false;
  while (count < most && !is_closed) {
    basis.col(count++) = next;
    product.perform_op(basis.col(count - 1).data(), next.data());
    const double size = next.norm();
    const auto own = basis.leftCols(count);
    Eigen::VectorXd part = own.transpose() * next;
    small.col(count - 1).head(count) = part;
    for (int twice = 0; twice < 2; ++twice, part = own.transpose() * next) next -= own * part;
    const double left = next.norm();
    is_closed = left <= kEnd * size;
    if (!is_closed) next /= left;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(
      small.topLeftCorner(count, count).selfadjointView<Eigen::Upper>());
  ExtremeEigen out;
  out.products = static_cast<std::size_t>(count);
  if (solver.info() != Eigen::Success) return out;
  const Eigen::VectorXd vector = basis.leftCols(count) * solver.eigenvectors().col(count - 1);
  out.value = solver.eigenvalues()[count - 1];
  out.vector = to_field(vector);
  out.converged = is_eigenpair(product, out.value, vector);
  return out;
}

/// Lanczos's recurrence b_k q_k+1 = A q_k - a_k q_k - b_k-1 q_k-1, one vector after the other. Rounding makes
/// them lose their orthogonality; the largest value of the tridiagonal matrix then only comes to be there
/// twice (C. C. Paige, J. Inst. Maths Applics 18 (1976), 341-349).
class Recurrence {
 public:
  Recurrence(const Product& product, const Eigen::VectorXd& start)
      : product_(product),
        vector_(start),
        before_(Eigen::VectorXd::Zero(start.size())),
        image_(start.size()) {}

  const Eigen::VectorXd& vector() const { return vector_; }

  /// Goes on to the next vector. Returns a_k and b_k; b_k is 0 where there is no next one.
  std::pair<double, double> step() {
    constexpr double kEnd = 1e-10;
    product_.perform_op(vector_.data(), image_.data());
    const double size = image_.norm();
    const double diagonal = vector_.dot(image_);
    image_ -= diagonal * vector_ + beside_ * before_;
    const double left = image_.norm();
    if (left <= kEnd * size) return {diagonal, 0.0};
    beside_ = left;
    before_.swap(vector_);
    vector_ = image_ / left;
    return {diagonal, left};
  }

 private:
  const Product& product_;
  Eigen::VectorXd vector_;
  Eigen::VectorXd before_;
  Eigen::VectorXd image_;
  double beside_ = 0.0;
};

/// The largest eigenvalue of a tridiagonal matrix, with its vector.
struct TopOfTridiagonal {
  double value = 0.0;
  Eigen::VectorXd coefficients;
  bool converged = false;
};

/// The vector by inverse iteration: just above its largest eigenvalue, sigma - T is positive definite.
Eigen::VectorXd top_vector(const std::vector<double>& diagonal, const std::vector<double>& beside,
                           double value) {
  const std::size_t n = diagonal.size();
  double scale = 0.0;
  for (std::size_t k = 0; k < n; ++k) scale = std::max(scale, std::abs(diagonal[k]) + beside[k]);
  const double sigma = value + 1e-14 * static_cast<double>(n) * std::max(scale, std::abs(value));
  std::vector<double> pivot(n);
  for (std::size_t k = 0; k < n; ++k) {
    const double taken = k == 0 ? 0.0 : beside[k - 1] * beside[k - 1] / pivot[k - 1];
    pivot[k] = std::max(sigma - diagonal[k] - taken, std::numeric_limits<double>::min());
  }
  Eigen::VectorXd x = Eigen::VectorXd::Ones(static_cast<Eigen::Index>(n));
  constexpr int kIterations = 3;
  for (int round = 0; round < kIterations; ++round) {
    for (std::size_t k = 1; k < n; ++k)
      x[signed_index(k)] += beside[k - 1] / pivot[k - 1] * x[signed_index(k - 1)];
    for (std::size_t k = n; k-- > 0;) {
      const double next = k + 1 < n ? beside[k] * x[signed_index(k + 1)] : 0.0;
      x[signed_index(k)] = (x[signed_index(k)] + next) / pivot[k];
    }
    x /= x.lpNorm<Eigen::Infinity>();
  }
  return x.normalized();
}

/// Steps until the largest value stands to the tolerance, looked at now and then.
TopOfTridiagonal find_top(const Product& product, const Eigen::VectorXd& start) {
  constexpr std::size_t kMostSteps = 3000;
  constexpr std::size_t kFirstLook = 10;
  Recurrence lanczos(product, start);
  std::vector<double> diagonal;
  std::vector<double> beside;
  TopOfTridiagonal top;
  std::size_t next_look = kFirstLook;
  while (diagonal.size() < kMostSteps && !top.converged) {
    const auto [a, b] = lanczos.step();
    diagonal.push_back(a);
    beside.push_back(b);
    if (!std::isfinite(a) || !std::isfinite(b)) return top;
    if (b != 0.0 && diagonal.size() < next_look) continue;
    next_look += std::max(kFirstLook, next_look / 10);
    const auto n = signed_index(diagonal.size());
    Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver;
    solver.computeFromTridiagonal(Eigen::Map<const Eigen::VectorXd>(diagonal.data(), n),
                                  Eigen::Map<const Eigen::VectorXd>(beside.data(), n - 1),
                                  Eigen::EigenvaluesOnly);
    if (solver.info() != Eigen::Success) return top;
    top.value = solver.eigenvalues()[n - 1];
    top.coefficients = top_vector(diagonal, beside, top.value);
    top.converged = b == 0.0 || b * std::abs(top.coefficients[n - 1]) <= kTolerance * std::abs(top.value);
    if (b == 0.0) break;
  }
  return top;
}

/// The sum of the recurrence's vectors times the coefficients; they are made anew, and none is kept.
Eigen::VectorXd combine(const Product& product, const Eigen::VectorXd& start,
                        const Eigen::VectorXd& coefficients) {
  Recurrence lanczos(product, start);
  Eigen::VectorXd sum = coefficients[0] * lanczos.vector();
  for (Eigen::Index k = 1; k < coefficients.size(); ++k) {
    lanczos.step();
    sum += coefficients[k] * lanczos.vector();
  }
  return sum.normalized();
}

/// A seeded vector of length 1, near the guess if there is one.
Eigen::VectorXd start_vector(Eigen::Index n, std::span<const Vec3> guess) {
  constexpr double kBeside = 0.1;  // of the guess: what it lacks is to be found
  SplitMix64 random(1);
  Eigen::VectorXd out(n);
  for (Eigen::Index k = 0; k < n; ++k) out[k] = random.uniform() - 0.5;
  out.normalize();
  if (guess.empty()) return out;
  out *= kBeside * norm_of(guess);
  for (std::size_t v = 0; v < guess.size(); ++v) {
    for (std::size_t i = 0; i < 3; ++i) out[signed_index(3 * v + i)] += component(guess[v], i);
  }
  return out.normalized();
}

}  // namespace

FastestRates find_fastest_rates(const BlockMatrix& stiffness, const BlockMatrix& damping,
                                double stiffness_max, int threads) {
  require(stiffness.rows() > 0 && damping.rows() == stiffness.rows() && stiffness_max > 0.0,
          "two matrices of the same rows, and a scale");
  RateProduct product(stiffness, damping, std::sqrt(stiffness_max), threads);
  const Eigen::Index wanted = std::min<Eigen::Index>(8, product.rows() - 2);
  const Eigen::Index most_vectors = 40;
  constexpr Eigen::Index kRestarts = 200;
  Spectra::GenEigsSolver<RateProduct> solver(product, wanted, std::min(most_vectors, product.rows()));
  FastestRates out;
  try {
    solver.init();
    solver.compute(Spectra::SortRule::LargestMagn, kRestarts, kTolerance);
  } catch (const std::runtime_error&) {
    return out;  // a breakdown: not converged
  }
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

ExtremeEigen find_largest_eigenvalue(const BlockMatrix& matrix, int threads, std::span<const Vec3> guess) {
  require(matrix.rows() > 0, "at least one row");
  require(guess.empty() || guess.size() == matrix.rows(), "a guess of one vector a row");
  const Product product(matrix, threads);
  const Eigen::VectorXd start = start_vector(product.rows(), guess);
  const TopOfTridiagonal top = find_top(product, start);
  ExtremeEigen out;
  if (top.converged) {
    const Eigen::VectorXd vector = combine(product, start, top.coefficients);
    out.products = 2 * static_cast<std::size_t>(top.coefficients.size()) + 1;
    out.converged = is_eigenpair(product, top.value, vector);
    out.value = top.value;
    out.vector = to_field(vector);
  }
  // The plain recurrence has lost its way, or came to its end beside rounding.
  if (!out.converged) return find_by_plain_lanczos(product);
  return out;
}

}  // namespace palpate::dynamics

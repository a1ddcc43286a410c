#include "tests/support/dense_nonnegative.h"

#include <algorithm>
#include <cmath>

namespace palpate::springs::testing_support {
namespace {

std::vector<double> negative_gradient(const DenseMatrix& matrix, std::span<const double> rhs,
                                      std::span<const double> x) {
  std::vector<double> pull(matrix.columns, 0.0);
  for (std::size_t r = 0; r < matrix.rows; ++r) {
    double left = rhs[r];
    for (std::size_t c = 0; c < matrix.columns; ++c) left -= matrix.at(r, c) * x[c];
    for (std::size_t c = 0; c < matrix.columns; ++c) pull[c] += matrix.at(r, c) * left;
  }
  return pull;
}

// Applies the reflection that empties column `k` of `work` below row `k`, to the columns from k on and to
// rhs.
void reflect(std::vector<std::vector<double>>& work, std::vector<double>& rhs, std::size_t k) {
  double norm = 0.0;
  for (std::size_t r = k; r < rhs.size(); ++r) norm += work[k][r] * work[k][r];
  norm = std::sqrt(norm);
  if (norm == 0.0) return;
  std::vector<double> v(work[k].begin() + static_cast<std::ptrdiff_t>(k), work[k].end());
  v[0] += v[0] < 0.0 ? -norm : norm;
  double length_sq = 0.0;
  for (const double value : v) length_sq += value * value;
  const auto apply = [&](std::vector<double>& column) {
    double along = 0.0;
    for (std::size_t i = 0; i < v.size(); ++i) along += v[i] * column[k + i];
    for (std::size_t i = 0; i < v.size(); ++i) column[k + i] -= 2.0 * along / length_sq * v[i];
  };
  for (std::size_t c = k; c < work.size(); ++c) apply(work[c]);
  apply(rhs);
}

}  // namespace

LinearMap as_map(const DenseMatrix& matrix) {
  LinearMap map;
  map.rows = matrix.rows;
  map.columns = matrix.columns;
  map.column_norms_sq.assign(matrix.columns, 0.0);
  for (std::size_t r = 0; r < matrix.rows; ++r)
    for (std::size_t c = 0; c < matrix.columns; ++c)
      map.column_norms_sq[c] += matrix.at(r, c) * matrix.at(r, c);
  map.apply = [&matrix](std::span<const double> x, std::span<double> y) {
    for (std::size_t r = 0; r < matrix.rows; ++r) {
      y[r] = 0.0;
      for (std::size_t c = 0; c < matrix.columns; ++c) y[r] += matrix.at(r, c) * x[c];
    }
  };
  map.apply_transposed = [&matrix](std::span<const double> y, std::span<double> x) {
    std::fill(x.begin(), x.end(), 0.0);
    for (std::size_t r = 0; r < matrix.rows; ++r)
      for (std::size_t c = 0; c < matrix.columns; ++c) x[c] += matrix.at(r, c) * y[r];
  };
  return map;
}

std::vector<double> solve_on_columns(const DenseMatrix& matrix, std::span<const double> rhs,
                                     const std::vector<std::size_t>& free) {
  std::vector<std::vector<double>> work(free.size(), std::vector<double>(matrix.rows));
  for (std::size_t k = 0; k < free.size(); ++k)
    for (std::size_t r = 0; r < matrix.rows; ++r) work[k][r] = matrix.at(r, free[k]);
  std::vector<double> right(rhs.begin(), rhs.end());
  for (std::size_t k = 0; k < free.size(); ++k) reflect(work, right, k);
  std::vector<double> x(matrix.columns, 0.0);
  for (std::size_t k = free.size(); k-- > 0;) {
    double value = right[k];
    for (std::size_t c = k + 1; c < free.size(); ++c) value -= work[c][k] * x[free[c]];
    x[free[k]] = value / work[k][k];
  }
  return x;
}

double objective(const DenseMatrix& matrix, std::span<const double> rhs, std::span<const double> x) {
  double sum = 0.0;
  for (std::size_t r = 0; r < matrix.rows; ++r) {
    double left = -rhs[r];
    for (std::size_t c = 0; c < matrix.columns; ++c) left += matrix.at(r, c) * x[c];
    sum += left * left;
  }
  return sum;
}

std::vector<double> minimum_by_enumeration(const DenseMatrix& matrix, std::span<const double> rhs) {
  std::vector<double> best(matrix.columns, 0.0);
  double least = objective(matrix, rhs, best);
  for (std::size_t set = 1; set < (std::size_t{1} << matrix.columns); ++set) {
    std::vector<std::size_t> free;
    for (std::size_t c = 0; c < matrix.columns; ++c)
      if ((set >> c & 1U) != 0) free.push_back(c);
    const std::vector<double> x = solve_on_columns(matrix, rhs, free);
    if (*std::min_element(x.begin(), x.end()) < 0.0) continue;
    const double value = objective(matrix, rhs, x);
    if (value < least) {
      least = value;
      best = x;
    }
  }
  return best;
}

std::vector<double> minimum_by_active_sets(const DenseMatrix& matrix, std::span<const double> rhs) {
  std::vector<double> x(matrix.columns, 0.0);
  std::vector<bool> is_free(matrix.columns, false);
  const std::vector<double> first = negative_gradient(matrix, rhs, x);
  double size = 0.0;
  for (const double value : first) size = std::max(size, std::abs(value));
  for (std::size_t outer = 0; outer < 10 * matrix.columns; ++outer) {
    const std::vector<double> pull = negative_gradient(matrix, rhs, x);
    std::size_t enter = matrix.columns;
    for (std::size_t c = 0; c < matrix.columns; ++c)
      if (!is_free[c] && pull[c] > 1e-13 * size && (enter == matrix.columns || pull[c] > pull[enter]))
        enter = c;
    if (enter == matrix.columns) return x;
    is_free[enter] = true;
    while (true) {
      std::vector<std::size_t> free;
      for (std::size_t c = 0; c < matrix.columns; ++c)
        if (is_free[c]) free.push_back(c);
      const std::vector<double> trial = solve_on_columns(matrix, rhs, free);
      double length = 1.0;
      for (const std::size_t c : free)
        if (trial[c] <= 0.0) length = std::min(length, x[c] / (x[c] - trial[c]));
      const bool whole = std::all_of(free.begin(), free.end(), [&](std::size_t c) { return trial[c] > 0.0; });
      for (const std::size_t c : free) x[c] += length * (trial[c] - x[c]);
      if (whole) break;
      for (const std::size_t c : free)
        if (trial[c] <= 0.0 && x[c] <= 1e-15) {
          x[c] = 0.0;
          is_free[c] = false;
        }
    }
  }
  return x;
}

double dense_kkt(const DenseMatrix& matrix, std::span<const double> rhs, std::span<const double> x) {
  const std::vector<double> zero(matrix.columns, 0.0);
  const std::vector<double> at_zero = negative_gradient(matrix, rhs, zero);
  const std::vector<double> pull = negative_gradient(matrix, rhs, x);
  double residual = 0.0;
  double size = 0.0;
  for (std::size_t c = 0; c < matrix.columns; ++c) {
    double norm_sq = 0.0;
    for (std::size_t r = 0; r < matrix.rows; ++r) norm_sq += matrix.at(r, c) * matrix.at(r, c);
    if (norm_sq == 0.0) continue;
    const double scale = std::sqrt(norm_sq);
    residual = std::max(residual, std::abs(std::min(x[c] * scale, -pull[c] / scale)));
    size = std::max(size, std::abs(at_zero[c]) / scale);
  }
  return size > 0.0 ? residual / size : 0.0;
}

}  // namespace palpate::springs::testing_support

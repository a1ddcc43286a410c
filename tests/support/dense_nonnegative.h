// Dense references for least squares with x >= 0: for tests alone, small and slow.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/springs/solvers/nonnegative_least_squares.h"

namespace palpate::springs::testing_support {

/// A dense matrix, row by row.
struct DenseMatrix {
  std::size_t rows = 0;
  std::size_t columns = 0;
  std::vector<double> entry;

  double at(std::size_t row, std::size_t column) const { return entry[row * columns + column]; }
};

/// The map that the solver is given. The matrix must outlive it.
LinearMap as_map(const DenseMatrix& matrix);

/// The least-squares answer on the columns of `free`, zero elsewhere, by Householder reflections.
std::vector<double> solve_on_columns(const DenseMatrix& matrix, std::span<const double> rhs,
                                     const std::vector<std::size_t>& free);

/// |A x - b|^2.
double objective(const DenseMatrix& matrix, std::span<const double> rhs, std::span<const double> x);

/// The minimum over x >= 0 by trying every set of free columns (at most 12 columns).
std::vector<double> minimum_by_enumeration(const DenseMatrix& matrix, std::span<const double> rhs);

/// The minimum over x >= 0 by Lawson and Hanson's active sets (Solving Least Squares Problems, 1974, ch. 23).
std::vector<double> minimum_by_active_sets(const DenseMatrix& matrix, std::span<const double> rhs);

/// The KKT residual as nonnegative_least_squares.cpp defines it, computed densely from the rows.
double dense_kkt(const DenseMatrix& matrix, std::span<const double> rhs, std::span<const double> x);

}  // namespace palpate::springs::testing_support

// A factored matrix of one number a pair of vertices, which is solved for three right sides at once.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/base/types.h"

namespace palpate::dynamics {

/// An entry of a symmetric matrix, at both (row, column) and (column, row); several of one place add up.
struct ScalarEntry {
  Index row = 0;
  Index column = 0;
  double value = 0.0;
};

/// L L^T of a symmetric positive definite matrix A in an order that keeps L sparse (approximate minimum
/// degree). Factored in double precision, kept and applied in single: a solution has some six digits, which
/// is what an iteration that measures its own residual needs, and half the memory to read.
///
/// Shape:  offsets has one entry a column of L and one more; rows and values hold the entries below the
///         diagonal of column j at offsets[j] .. offsets[j + 1]; inverse_diagonal one entry a column;
///         place[v] is the column of row v of A.
struct LaplaceFactor {
  std::vector<std::size_t> offsets{0};
  std::vector<Index> rows;
  std::vector<float> values;
  std::vector<float> inverse_diagonal;
  std::vector<Index> place;

  std::size_t size() const { return place.size(); }
};

/// Factors the matrix of `size` rows with those entries; of each pair only one place is given. Throws:
/// InputError if it is not positive definite.
LaplaceFactor factor_laplace(std::size_t size, std::span<const ScalarEntry> entries);

/// Room for solve().
struct LaplaceScratch {
  std::vector<float> rows;  ///< four numbers a row
};

/// x = A^-1 b, for the three components of b together. `x` may be `b`.
void solve(const LaplaceFactor& factor, std::span<const Vec3> b, LaplaceScratch& scratch, std::span<Vec3> x);

}  // namespace palpate::dynamics

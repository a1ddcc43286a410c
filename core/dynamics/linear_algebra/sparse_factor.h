// A sparse symmetric matrix, factored once and solved for many right sides.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "core/dynamics/linear_algebra/block_matrix.h"

namespace palpate::dynamics {

/// The lower half of a symmetric matrix in compressed columns.
///
/// Shape:  offsets has one entry a column and one more; rows increase within a column, the diagonal first.
struct LowerHalf {
  std::vector<int> offsets{0};
  std::vector<int> rows;
  std::vector<double> values;

  std::size_t size() const { return offsets.size() - 1; }
};

/// The free components of a body, numbered.
///
/// Shape:  number has three entries a node; kNoIndex for a held component.
struct FreeNumbers {
  std::vector<Index> number;
  std::size_t count = 0;
};

/// `held` has one entry a node; bit i: axis i is held.
FreeNumbers number_free(std::span<const std::uint8_t> held);

/// The part of `matrix` between free components. Throws: InputError for more than 2^31 - 1 entries.
LowerHalf lower_half(const BlockMatrix& matrix, const FreeNumbers& free);

/// A factored matrix.
class SymmetricFactor {
 public:
  virtual ~SymmetricFactor() = default;
  /// Solves A X = B in place. Shape: `columns` holds right sides of size() numbers each, one after the other.
  virtual void solve(std::span<double> columns) const = 0;
  /// Entries of the factor.
  virtual std::size_t entries() const = 0;
};

/// Factors a matrix. Throws: UnavailableError if it is not positive definite or memory does not suffice.
using FactorMaker = std::function<std::unique_ptr<SymmetricFactor>(const LowerHalf&)>;

/// By Eigen's simplicial Cholesky method, column by column: slow on large matrices, but always there.
std::unique_ptr<SymmetricFactor> factor_simplicial(const LowerHalf& matrix);

}  // namespace palpate::dynamics

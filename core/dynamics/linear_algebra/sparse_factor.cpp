#include "core/dynamics/linear_algebra/sparse_factor.h"

#include <Eigen/SparseCholesky>
#include <limits>

#include "core/base/error.h"

namespace palpate::dynamics {
namespace {

using Sparse = Eigen::SparseMatrix<double>;

class SimplicialFactor : public SymmetricFactor {
 public:
  explicit SimplicialFactor(const LowerHalf& matrix) {
    const auto n = static_cast<Eigen::Index>(matrix.size());
    const Eigen::Map<const Sparse> lower(n, n, static_cast<Eigen::Index>(matrix.rows.size()),
                                         matrix.offsets.data(), matrix.rows.data(), matrix.values.data());
    factor_.compute(lower);
    if (factor_.info() != Eigen::Success)
      throw UnavailableError("the stiffness is not positive definite: it cannot be factored");
  }

  void solve(std::span<double> columns) const override {
    const Eigen::Index n = factor_.rows();
    if (n == 0) return;
    const auto count = static_cast<Eigen::Index>(columns.size()) / n;
    Eigen::Map<Eigen::MatrixXd> x(columns.data(), n, count);
    const Eigen::MatrixXd solved = factor_.solve(x);
    x = solved;
  }

  std::size_t entries() const override {
    return static_cast<std::size_t>(factor_.matrixL().nestedExpression().nonZeros());
  }

 private:
  Eigen::SimplicialLLT<Sparse, Eigen::Lower> factor_;
};

}  // namespace

FreeNumbers number_free(std::span<const std::uint8_t> held) {
  FreeNumbers free{std::vector<Index>(3 * held.size(), kNoIndex), 0};
  for (std::size_t v = 0; v < held.size(); ++v) {
    for (std::size_t i = 0; i < 3; ++i) {
      if (((static_cast<unsigned>(held[v]) >> i) & 1U) == 0)
        free.number[3 * v + i] = static_cast<Index>(free.count++);
    }
  }
  return free;
}

LowerHalf lower_half(const BlockMatrix& matrix, const FreeNumbers& free) {
  LowerHalf out;
  out.offsets.reserve(free.count + 1);
  if (9 * matrix.blocks.size() > static_cast<std::size_t>(std::numeric_limits<int>::max()))
    throw InputError("elements", 0, "fewer than 2^31 entries of the stiffness",
                     std::to_string(9 * matrix.blocks.size()));
  for (std::size_t v = 0; v < matrix.rows(); ++v) {
    for (std::size_t j = 0; j < 3; ++j) {
      const Index column = free.number[3 * v + j];
      if (column == kNoIndex) continue;
      for (std::size_t k = matrix.offsets[v]; k < matrix.offsets[v + 1]; ++k) {
        for (std::size_t i = 0; i < 3; ++i) {
          const Index row = free.number[3 * std::size_t{matrix.columns[k]} + i];
          if (row == kNoIndex || row < column) continue;
          out.rows.push_back(static_cast<int>(row));
          out.values.push_back(matrix.blocks[k](j, i));  // the matrix is symmetric
        }
      }
      out.offsets.push_back(static_cast<int>(out.rows.size()));
    }
  }
  return out;
}

std::unique_ptr<SymmetricFactor> factor_simplicial(const LowerHalf& matrix) {
  return std::make_unique<SimplicialFactor>(matrix);
}

}  // namespace palpate::dynamics

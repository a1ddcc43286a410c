#include "core/dynamics/linear_algebra/linear_solver.h"

#include <Eigen/SparseCholesky>
#include <cmath>
#include <optional>
#include <vector>

#include "core/base/error.h"
#include "core/dynamics/linear_algebra/block_cholesky.h"
#include "core/dynamics/linear_algebra/vertex_field.h"

namespace palpate::dynamics {
namespace {

using Sparse = Eigen::SparseMatrix<double>;
using Factor = Eigen::SimplicialLDLT<Sparse, Eigen::Lower>;

/// Above so many blocks in a matrix the factorisation's fill costs more than the iterations.
constexpr std::size_t kMostBlocksFactored = 4000;

/// Smaller blocks are left out of the preconditioner: it costs half as much and hardly converges slower.
constexpr double kDrop = 0.05;

/// The free components, numbered; kNoIndex for held ones.
std::vector<Index> number_free(std::span<const std::uint8_t> held, std::size_t& count) {
  std::vector<Index> number(3 * held.size(), kNoIndex);
  count = 0;
  for (std::size_t v = 0; v < held.size(); ++v) {
    for (std::size_t i = 0; i < 3; ++i) {
      if (((static_cast<unsigned>(held[v]) >> i) & 1U) == 0) number[3 * v + i] = static_cast<Index>(count++);
    }
  }
  return number;
}

/// The lower half of the free components' matrix.
Sparse lower_half(const BlockMatrix& matrix, const std::vector<Index>& number, std::size_t count) {
  Sparse lower(static_cast<Eigen::Index>(count), static_cast<Eigen::Index>(count));
  std::vector<int> per_column(count, 0);
  const auto for_each_entry = [&](auto&& use) {  // columns in order, rows increasing: the matrix is symmetric
    for (std::size_t v = 0; v < matrix.rows(); ++v) {
      for (std::size_t j = 0; j < 3; ++j) {
        const Index column = number[3 * v + j];
        if (column == kNoIndex) continue;
        for (std::size_t k = matrix.offsets[v]; k < matrix.offsets[v + 1]; ++k) {
          for (std::size_t i = 0; i < 3; ++i) {
            const Index row = number[3 * std::size_t{matrix.columns[k]} + i];
            if (row != kNoIndex && row >= column) use(row, column, matrix.blocks[k](j, i));
          }
        }
      }
    }
  };
  for_each_entry([&](Index, Index column, double) { ++per_column[column]; });
  lower.reserve(per_column);
  for_each_entry([&](Index row, Index column, double value) {
    lower.insert(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(column)) = value;
  });
  lower.makeCompressed();
  return lower;
}

}  // namespace

struct LinearSolver::State {
  LinearOptions options;
  const BlockMatrix* matrix = nullptr;
  std::span<const std::uint8_t> held;
  bool direct = false;
  bool analysed = false;
  std::size_t free_count = 0;
  std::vector<Index> number;
  Factor factor;
  BlockCholesky incomplete;

  LinearStatus prepare_direct() {
    if (!analysed) number = number_free(held, free_count);
    const Sparse lower = lower_half(*matrix, number, free_count);
    if (!analysed) factor.analyzePattern(lower);
    analysed = true;
    factor.factorize(lower);
    const bool is_positive = factor.info() == Eigen::Success && factor.vectorD().allFinite() &&
                             (free_count == 0 || factor.vectorD().minCoeff() > 0.0);
    return is_positive ? LinearStatus::kSolved : LinearStatus::kIndefinite;
  }

  LinearResult solve_direct(std::span<const Vec3> b, std::span<Vec3> x) const {
    Eigen::VectorXd rhs(static_cast<Eigen::Index>(free_count));
    const auto gather = [&](std::span<const Vec3> from) {
      for (std::size_t v = 0; v < from.size(); ++v) {
        const std::array<double, 3> entry{from[v].x, from[v].y, from[v].z};
        for (std::size_t i = 0; i < 3; ++i) {
          const Index place = number[3 * v + i];
          if (place != kNoIndex) rhs[static_cast<Eigen::Index>(place)] = entry[i];
        }
      }
    };
    gather(b);
    const Eigen::VectorXd solution = factor.solve(rhs);
    for (std::size_t v = 0; v < x.size(); ++v) {
      const auto at = [&](std::size_t i) {
        const Index place = number[3 * v + i];
        return place == kNoIndex ? 0.0 : solution[static_cast<Eigen::Index>(place)];
      };
      x[v] = {at(0), at(1), at(2)};
    }
    return {};
  }

  LinearResult iterate(std::span<const Vec3> b, std::span<Vec3> x) const;
};

LinearResult LinearSolver::State::iterate(std::span<const Vec3> b, std::span<Vec3> x) const {
  const std::size_t n = b.size();
  std::vector<Vec3> r(b.begin(), b.end());
  clear_held(held, r);
  std::fill(x.begin(), x.end(), Vec3{});
  const double target = options.tolerance * std::sqrt(dot_of(r, r));
  const double start = std::sqrt(dot_of(r, r));
  LinearResult result;
  if (start == 0.0) return result;
  std::vector<Vec3> z(n);
  std::vector<Vec3> p(n);
  std::vector<Vec3> ap(n);
  double rho_before = 0.0;
  const std::size_t most = options.max_iterations > 0 ? options.max_iterations : 20 * n + 1000;
  for (; result.iterations < most; ++result.iterations) {
    result.residual_relative = std::sqrt(dot_of(r, r)) / start;
    if (!(result.residual_relative * start > target)) return result;
    apply_inverse(incomplete, r, z);
    const double rho = dot_of(r, z);
    const double beta = result.iterations == 0 ? 0.0 : rho / rho_before;
    for (std::size_t v = 0; v < n; ++v) p[v] = z[v] + beta * p[v];
    rho_before = rho;
    multiply(*matrix, p, ap, options.threads);
    clear_held(held, ap);
    const double curvature = dot_of(p, ap);
    if (!(curvature > 0.0)) {
      result.status = LinearStatus::kIndefinite;
      return result;
    }
    add_scaled(x, rho / curvature, p);
    add_scaled(r, -rho / curvature, ap);
  }
  result.status = LinearStatus::kNotConverged;
  return result;
}

LinearSolver::LinearSolver(const LinearOptions& options) : state_(std::make_unique<State>()) {
  state_->options = options;
}
LinearSolver::~LinearSolver() = default;
LinearSolver::LinearSolver(LinearSolver&&) noexcept = default;
LinearSolver& LinearSolver::operator=(LinearSolver&&) noexcept = default;

LinearStatus LinearSolver::prepare(const BlockMatrix& matrix, std::span<const std::uint8_t> held) {
  require(held.size() == matrix.rows(), "one flag a row");
  state_->matrix = &matrix;
  state_->held = held;
  const LinearMethod method = state_->options.method;
  state_->direct = method == LinearMethod::kDirect ||
                   (method == LinearMethod::kAuto && matrix.blocks.size() <= kMostBlocksFactored);
  if (state_->direct) return state_->prepare_direct();
  state_->incomplete = factor_incomplete(matrix, held, kDrop);
  return LinearStatus::kSolved;
}

LinearResult LinearSolver::solve(std::span<const Vec3> b, std::span<Vec3> x) const {
  require(state_->matrix != nullptr && b.size() == state_->matrix->rows() && x.size() == b.size(),
          "a prepared solver, one entry a row");
  return state_->direct ? state_->solve_direct(b, x) : state_->iterate(b, x);
}

bool LinearSolver::is_direct() const {
  return state_->direct;
}

void LinearSolver::set_tolerance(double tolerance) {
  state_->options.tolerance = tolerance;
}

}  // namespace palpate::dynamics

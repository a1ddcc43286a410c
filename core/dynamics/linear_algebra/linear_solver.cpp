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

/// The same of a matrix that is kept, by a supernodal method (some 30,000 vertices of smoothed elements: a
/// gigabyte), and column by column (1,000: seconds).
constexpr std::size_t kMostBlocksKept = 2'000'000;
constexpr std::size_t kMostBlocksKeptBySimplicial = 60'000;

/// Smaller blocks are left out of the preconditioner: it costs half as much and hardly converges slower.
constexpr double kDrop = 0.05;

}  // namespace

struct LinearSolver::State {
  LinearOptions options;
  const BlockMatrix* matrix = nullptr;
  std::span<const std::uint8_t> held;
  bool direct = false;
  bool analysed = false;
  FreeNumbers free;
  Factor factor;
  std::unique_ptr<SymmetricFactor> kept;
  BlockCholesky incomplete;

  LinearStatus prepare_direct() {
    if (!analysed) free = number_free(held);
    const LowerHalf half = lower_half(*matrix, free);
    const auto n = static_cast<Eigen::Index>(half.size());
    const Eigen::Map<const Sparse> lower(n, n, static_cast<Eigen::Index>(half.rows.size()),
                                         half.offsets.data(), half.rows.data(), half.values.data());
    if (!analysed) factor.analyzePattern(lower);
    analysed = true;
    factor.factorize(lower);
    const bool is_positive = factor.info() == Eigen::Success && factor.vectorD().allFinite() &&
                             (free.count == 0 || factor.vectorD().minCoeff() > 0.0);
    return is_positive ? LinearStatus::kSolved : LinearStatus::kIndefinite;
  }

  /// Leaves `kept` empty where the factors are not to be had.
  void prepare_kept() {
    const std::size_t most = options.factor ? kMostBlocksKept : kMostBlocksKeptBySimplicial;
    if (matrix->blocks.size() > most) return;
    if (free.number.empty()) free = number_free(held);
    const LowerHalf half = lower_half(*matrix, free);
    try {
      kept = options.factor ? options.factor(half) : factor_simplicial(half);
    } catch (const UnavailableError&) {  // no room, or not definite: conjugate gradients find out which
    }
  }

  LinearResult solve_direct(std::span<const Vec3> b, std::span<Vec3> x) const {
    Eigen::VectorXd solution(static_cast<Eigen::Index>(free.count));
    for (std::size_t v = 0; v < b.size(); ++v) {
      const std::array<double, 3> entry{b[v].x, b[v].y, b[v].z};
      for (std::size_t i = 0; i < 3; ++i) {
        const Index place = free.number[3 * v + i];
        if (place != kNoIndex) solution[static_cast<Eigen::Index>(place)] = entry[i];
      }
    }
    if (kept) {
      kept->solve({solution.data(), free.count});
    } else {
      solution = factor.solve(solution).eval();
    }
    for (std::size_t v = 0; v < x.size(); ++v) {
      const auto at = [&](std::size_t i) {
        const Index place = free.number[3 * v + i];
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

LinearStatus LinearSolver::prepare(const BlockMatrix& matrix, std::span<const std::uint8_t> held,
                                   MatrixUse use) {
  require(held.size() == matrix.rows(), "one flag a row");
  state_->matrix = &matrix;
  state_->held = held;
  state_->kept.reset();
  const LinearMethod method = state_->options.method;
  state_->direct = method == LinearMethod::kDirect ||
                   (method == LinearMethod::kAuto && matrix.blocks.size() <= kMostBlocksFactored);
  if (state_->direct) return state_->prepare_direct();
  if (method == LinearMethod::kAuto && use == MatrixUse::kKept) state_->prepare_kept();
  state_->direct = state_->kept != nullptr;
  if (!state_->direct) state_->incomplete = factor_incomplete(matrix, held, kDrop);
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

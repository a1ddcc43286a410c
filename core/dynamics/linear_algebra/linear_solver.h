// Solves with a tangent: a sparse factorisation for small systems, conjugate gradients for large ones.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "core/dynamics/linear_algebra/block_matrix.h"
#include "core/dynamics/linear_algebra/sparse_factor.h"

namespace palpate::dynamics {

/// kAuto takes the factorisation for matrices of few blocks, and for larger ones that are kept.
enum class LinearMethod { kAuto, kDirect, kConjugateGradients };

/// How a symmetric system is solved.
struct LinearOptions {
  LinearMethod method = LinearMethod::kAuto;
  double tolerance = 1e-10;        ///< conjugate gradients: |r| / |b|
  std::size_t max_iterations = 0;  ///< conjugate gradients; 0: 20 x rows + 1000
  int threads = 1;
  FactorMaker factor = {};  ///< kAuto: what factors matrices that are kept; empty: Eigen's method
};

/// How often a matrix is solved with: once or a few times, or so often that its factors are worth their
/// price.
enum class MatrixUse { kFewTimes, kKept };

/// kIndefinite: a pivot, or a direction of the conjugate gradients, has a curvature <= 0.
enum class LinearStatus { kSolved, kIndefinite, kNotConverged };

/// How a solve ended.
struct LinearResult {
  LinearStatus status = LinearStatus::kSolved;
  std::size_t iterations = 0;  ///< 0 for the factorisation
  double residual_relative = 0.0;
};

/// A symmetric system whose held components (bit i of held[v]: axis i of vertex v) are left out.
/// Deterministic for any number of threads.
class LinearSolver {
 public:
  explicit LinearSolver(const LinearOptions& options);
  ~LinearSolver();
  LinearSolver(LinearSolver&&) noexcept;
  LinearSolver& operator=(LinearSolver&&) noexcept;

  /// Factors the matrix, or builds the preconditioner; what depends on the pattern alone is kept from one
  /// call to the next. `matrix` and `held` must live on while solve() is called. A matrix that is kept
  /// (kAuto) is factored up to two million blocks with a `factor`, up to 60,000 without; where its factors
  /// do not fit into the memory, conjugate gradients take over.
  ///
  /// Returns: kIndefinite where a factorisation met a pivot <= 0; else kSolved.
  LinearStatus prepare(const BlockMatrix& matrix, std::span<const std::uint8_t> held,
                       MatrixUse use = MatrixUse::kFewTimes);

  /// Solves A x = b in the free components; the held ones of x become zero. Those of b are ignored.
  LinearResult solve(std::span<const Vec3> b, std::span<Vec3> x) const;

  /// Whether prepare() factored.
  bool is_direct() const;

  void set_tolerance(double tolerance);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace palpate::dynamics

// Sparse linear least squares with x >= 0, matrix-free.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

namespace palpate::springs {

/// A linear map by its action: rows x columns. `apply` overwrites y = A x, `apply_transposed` overwrites x =
/// A^T y, `column_norms_sq` gives the squared length of each column (the diagonal of A^T A).
struct LinearMap {
  std::size_t rows = 0;
  std::size_t columns = 0;
  std::function<void(std::span<const double> x, std::span<double> y)> apply;
  std::function<void(std::span<const double> y, std::span<double> x)> apply_transposed;
  std::vector<double> column_norms_sq;
};

/// A least-squares problem by its normal equations:
/// |A x - b|^2 = x.G x - 2 c.x + const, G = A^T A, c = A^T b.
///
/// Shape: `diagonal` (of G) and `linear` (c) hold one entry a column; both actions overwrite y.
struct NormalEquations {
  std::vector<double> diagonal;
  std::vector<double> linear;
  std::function<void(std::span<const double> x, std::span<double> y)> apply;  ///< y = G x
  /// y = G x in single precision, or empty. Only corrections are computed with it; the answer's residual
  /// never is.
  std::function<void(std::span<const float> x, std::span<float> y)> apply_single;
};

/// When the search stops, and what is added to the problem.
struct NonnegativeOptions {
  double tolerance = 1e-10;          ///< of the relative KKT residual
  std::size_t max_iterations = 0;    ///< outer; 0: 500
  double ridge = 0.0;                ///< adds ridge x |x - toward|^2, in the units of A^T A
  std::span<const double> toward{};  ///< one a column, or empty: zero
};

/// What became of the search.
struct NonnegativeReport {
  std::size_t iterations = 0;     ///< outer
  std::size_t cg_iterations = 0;  ///< all inner ones
  double kkt_relative =
      0.0;  ///< max over columns of |min(x_j, g_j)| after scaling; defined in the .cpp's first lines
  std::size_t zeros = 0;  ///< columns at the bound
  bool converged = false;
};

/// Minimises |A x - b|^2 + ridge |x - toward|^2 over x >= 0. Deterministic; memory linear in rows + columns.
///
/// `x` holds the start on entry (zeros are fine) and the answer on return: finite and >= 0 always. A column
/// of zeros keeps its start. Where the minimum is not unique, the answer depends on the start.
/// Throws: ContractError if the sizes differ or an entry of the problem or the start is not finite.
NonnegativeReport solve_nonnegative(const LinearMap& map, std::span<const double> rhs, std::span<double> x,
                                    const NonnegativeOptions& options);

/// The same by the normal equations.
NonnegativeReport solve_nonnegative(const NormalEquations& equations, std::span<double> x,
                                    const NonnegativeOptions& options);

}  // namespace palpate::springs

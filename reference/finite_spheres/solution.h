// The coefficients at rest.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "core/base/enum_names.h"
#include "reference/finite_spheres/sphere_system.h"

namespace palpate::reference {

/// kAuto factors systems of few entries and iterates for others.
enum class SphereSolver { kAuto, kDirect, kConjugateGradients };

/// By the option `solver`.
inline constexpr EnumNames<SphereSolver, 3> kSphereSolverNames{"solver", {"auto", "direct", "cg"}};

/// How the system is solved.
struct SphereSolverOptions {
  SphereSolver solver = SphereSolver::kAuto;
  double tolerance = 1e-10;  ///< of the conjugate gradients: |f - K a| / |f|
  std::size_t most_iterations = 20000;
  int threads = 1;
};

/// What came of it.
struct SphereSolution {
  std::vector<Vec3> coefficients_m;
  bool converged = false;
  bool indefinite = false;  ///< a pivot, or a direction, without stiffness
  bool factored = false;
  std::size_t factor_entries = 0;  ///< 0 for the conjugate gradients
  std::size_t iterations = 0;      ///< of the conjugate gradients, or corrections after the factorisation
  double residual_relative = 0.0;  ///< |f - K a| / |f|, computed anew
};

/// Solves K a = f by a sparse Cholesky factorisation (Eigen, with one correction), or by conjugate gradients
/// with incomplete Cholesky factors by blocks.
SphereSolution solve_spheres(const SphereSystem& system, const SphereSolverOptions& options);

}  // namespace palpate::reference

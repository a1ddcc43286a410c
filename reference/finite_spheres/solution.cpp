#include "reference/finite_spheres/sphere_system.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>

#include "core/base/error.h"
#include "core/dynamics/linear_algebra/linear_solver.h"
#include "core/dynamics/linear_algebra/sparse_factor.h"
#include "core/dynamics/linear_algebra/vertex_field.h"

namespace palpate::reference {
namespace {

/// Above so many blocks of the matrix the iterations are faster than the factorisation.
constexpr std::size_t kMostBlocksFactored = 40000;

/// A factorisation that leaves more than this is no solution.
constexpr double kMostResidual = 1e-6;

std::vector<Vec3> residual_of(const SphereSystem& system, std::span<const Vec3> right,
                              std::span<const Vec3> a) {
  std::vector<Vec3> left(right.begin(), right.end());
  std::vector<Vec3> pull(a.size());
  dynamics::multiply(system.matrix, a, pull);
  dynamics::add_scaled(left, -1.0, pull);
  return left;
}

void correct(const dynamics::SymmetricFactor& factor, std::span<const Vec3> residual, std::vector<Vec3>& a) {
  std::vector<double> column;
  column.reserve(3 * residual.size());
  for (const Vec3& r : residual) column.insert(column.end(), {r.x, r.y, r.z});
  factor.solve(column);
  for (std::size_t i = 0; i < a.size(); ++i)
    a[i] = a[i] + Vec3{column[3 * i], column[3 * i + 1], column[3 * i + 2]};
}

void solve_direct(const SphereSystem& system, std::span<const Vec3> right, SphereSolution& found) {
  found.factored = true;
  const std::vector<std::uint8_t> held(right.size(), 0);
  std::unique_ptr<dynamics::SymmetricFactor> factor;
  try {
    factor = dynamics::factor_simplicial(dynamics::lower_half(system.matrix, dynamics::number_free(held)));
  } catch (const UnavailableError&) {  // a numerical outcome here: data of the report
    found.indefinite = true;
    return;
  }
  found.factor_entries = factor->entries();
  correct(*factor, right, found.coefficients_m);
  correct(*factor, residual_of(system, right, found.coefficients_m), found.coefficients_m);
  found.iterations = 1;
}

void iterate(const SphereSystem& system, std::span<const Vec3> right, const SphereSolverOptions& options,
             SphereSolution& found) {
  const std::vector<std::uint8_t> held(right.size(), 0);
  dynamics::LinearSolver solver({dynamics::LinearMethod::kConjugateGradients, options.tolerance,
                                 options.most_iterations, options.threads});
  solver.prepare(system.matrix, held);
  const dynamics::LinearResult result = solver.solve(right, found.coefficients_m);
  found.iterations = result.iterations;
  found.indefinite = result.status == dynamics::LinearStatus::kIndefinite;
}

}  // namespace

SphereSolution solve_spheres(const SphereSystem& system, const SphereSolverOptions& options) {
  SphereSolution found;
  std::vector<Vec3> right = system.dead_n;
  dynamics::add_scaled(right, 1.0, system.moved_n);
  found.coefficients_m.resize(right.size());
  const bool is_direct =
      options.solver == SphereSolver::kDirect ||
      (options.solver == SphereSolver::kAuto && system.matrix.blocks.size() <= kMostBlocksFactored);
  if (is_direct) {
    solve_direct(system, right, found);
  } else {
    iterate(system, right, options, found);
  }
  const double load = dynamics::norm_of(right);
  const double left = dynamics::norm_of(residual_of(system, right, found.coefficients_m));
  found.residual_relative = load > 0.0 ? left / load : 0.0;
  // The residual that the iterations keep by recurrence drifts from the true one by rounding.
  const double enough = is_direct ? kMostResidual : std::max(10.0 * options.tolerance, 1e-12);
  found.converged = !found.indefinite && std::isfinite(left) && found.residual_relative <= enough;
  return found;
}

}  // namespace palpate::reference

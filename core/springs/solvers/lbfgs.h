// Minimisation of a smooth function by limited-memory quasi-Newton steps.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

namespace palpate::springs {

/// When the search stops, and how far it steps.
struct LbfgsOptions {
  std::size_t max_iterations = 200;
  std::size_t memory = 12;           ///< pairs of steps and gradient changes that are kept
  double gradient_tolerance = 1e-6;  ///< stops at |g| <= this x |g at the start|
  double decrease_tolerance = 1e-9;  ///< stops when a step lowers f by less than this x |f|
  double first_step = 1.0;           ///< largest change of an entry in the first step
};

/// Why it stopped: the gradient or the decrease is below its tolerance, too many iterations, or no step
/// lowers f.
enum class LbfgsStop { kGradient, kDecrease, kIterations, kNoDescent };

/// What became of the search.
struct LbfgsReport {
  std::size_t iterations = 0;
  std::size_t evaluations = 0;
  double start_value = 0.0;
  double value = 0.0;
  double gradient_norm = 0.0;
  LbfgsStop stop = LbfgsStop::kGradient;
};

/// Returns f(x) and overwrites `gradient`. May return infinity where f has no value: the step is shortened.
using SmoothFunction = std::function<double(std::span<const double> x, std::span<double> gradient)>;

/// Minimises f from x, which holds the best point on return. The value never rises. Deterministic.
///
/// Steps satisfy f(x + a d) <= f(x) + 1e-4 a g.d; a pair without positive curvature is not kept.
/// Throws: ContractError if f or its gradient is not finite at the start.
/// Source: Nocedal and Wright, Numerical Optimization, 2nd ed., algorithms 7.4 and 7.5.
LbfgsReport minimize_lbfgs(const SmoothFunction& f, std::vector<double>& x, const LbfgsOptions& options);

}  // namespace palpate::springs

// Minimises |A x - b|^2 + r |x - t|^2 over x >= 0 by projected Newton steps on the normal equations.
//
// With G = A^T A + r I, c = A^T b + r t, gradient g = G x - c and column lengths s_j = sqrt(G_jj), the scaled
// unknowns and gradients are s_j x_j and g_j / s_j. The KKT residual is
//
//   max_j |min(s_j x_j, g_j / s_j)| / max_j |c_j / s_j|,
//
// 0 at the minimum alone, the same in every unit of x and of b.
//
// Each step frees the columns with s_j x_j > g_j / s_j, sends the others to zero, and solves for the free
// ones by conjugate gradients (in single precision where the caller offers it), only as well as the step
// needs. The end is clipped at zero and the step halved until the objective falls; where that fails, a scaled
// gradient step takes its place, whose descent is certain; where clipped steps stall, straight ones to the
// first bound in the way. So the objective never rises and no set of free columns can come twice for ever.
// The gradient is computed anew in double precision after each step: what the inner solve rounds off costs
// iterations, never accuracy. Source: Bertsekas, Projected Newton methods, SIAM J. Control Optim. 20 (1982);
// the free set is that of the primal-dual active set method (Hintermueller, Ito and Kunisch, SIAM J. Optim.
// 13, 2002).
#include "core/springs/solvers/nonnegative_least_squares.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

#include "core/base/error.h"
#include "core/springs/solvers/sufficient_decrease.h"

namespace palpate::springs {
namespace {

constexpr std::size_t kDefaultIterations = 500;
constexpr std::size_t kInnerIterations = 3000;  // of one step
constexpr std::size_t kAllInnerIterations = 20000;
constexpr int kHalvings = 12;              // of a Newton step
constexpr int kGradientHalvings = 60;      // of a scaled gradient step
constexpr int kStraightSteps = 200;        // in a row, where clipped ones stall
constexpr double kFirstAccuracy = 0.1;     // of the inner solves, relative to their first residual,
constexpr double kSettledAccuracy = 0.01;  // at most so once the free set stays,
constexpr double kSingleAccuracy = 1e-4;   // as much as single precision is asked for,
constexpr double kLastAccuracy = 1e-10;    // the most that is asked for
constexpr double kEnough = 0.2;            // share of the tolerance that an inner solve aims at
constexpr int kPatience = 4;               // poor steps in a row before accuracy rises with each

// Sum of a_j b_j in four interleaved parts: the order of the additions is fixed, and no chain is long.
template <typename Scalar>
double dot_product(const std::vector<Scalar>& a, const std::vector<Scalar>& b) {
  double part0 = 0.0;
  double part1 = 0.0;
  double part2 = 0.0;
  double part3 = 0.0;
  std::size_t j = 0;
  for (; j + 4 <= a.size(); j += 4) {
    part0 += static_cast<double>(a[j]) * b[j];
    part1 += static_cast<double>(a[j + 1]) * b[j + 1];
    part2 += static_cast<double>(a[j + 2]) * b[j + 2];
    part3 += static_cast<double>(a[j + 3]) * b[j + 3];
  }
  for (; j < a.size(); ++j) part0 += static_cast<double>(a[j]) * b[j];
  return (part0 + part1) + (part2 + part3);
}

// Calls y = G x in the precision of its arguments.
void apply_normal(const NormalEquations& equations, std::span<const double> x, std::span<double> y) {
  equations.apply(x, y);
}
void apply_normal(const NormalEquations& equations, std::span<const float> x, std::span<float> y) {
  equations.apply_single(x, y);
}

// The problem in scaled unknowns z_j = s_j x_j, whose matrix has a unit diagonal.
struct ScaledProblem {
  const NormalEquations& equations;
  double ridge = 0.0;
  std::vector<double> linear;         // c_j / s_j, ridge included
  std::vector<double> inverse_scale;  // 1 / s_j; 0 for a column of zeros
  double size = 0.0;                  // max |c_j / s_j|
  std::vector<double> x;              // work: unscaled
};

// gradient = G z - c, all scaled.
void compute_gradient(ScaledProblem& problem, const std::vector<double>& z, std::vector<double>& gradient) {
  const std::size_t count = z.size();
  for (std::size_t j = 0; j < count; ++j) problem.x[j] = z[j] * problem.inverse_scale[j];
  problem.equations.apply(problem.x, gradient);
  for (std::size_t j = 0; j < count; ++j)
    gradient[j] = (gradient[j] + problem.ridge * problem.x[j]) * problem.inverse_scale[j] - problem.linear[j];
}

// One Newton direction for the free columns, and its conjugate gradients in single or double precision.
template <typename Scalar>
class InnerSolver {
 public:
  explicit InnerSolver(const ScaledProblem& problem)
      : problem_(problem),
        scale_(problem.inverse_scale.begin(), problem.inverse_scale.end()),
        step_(scale_.size()),
        residual_(scale_.size()),
        direction_(scale_.size()),
        unscaled_(scale_.size()),
        image_(scale_.size()) {}

  // direction = the step to zero for columns that are not free; for the free ones, G_FF d_F = -g_F - G_FA
  // d_A to `accuracy`. Returns the number of iterations.
  std::size_t solve(const std::vector<double>& z, const std::vector<double>& gradient,
                    const std::vector<std::uint8_t>& is_free, double accuracy,
                    std::vector<double>& direction) {
    const std::size_t count = z.size();
    double unit = 0.0;
    for (std::size_t j = 0; j < count; ++j)
      unit = std::max(unit, std::abs(is_free[j] != 0 ? gradient[j] : z[j]));
    if (unit == 0.0) unit = 1.0;
    bool any_moves = false;
    for (std::size_t j = 0; j < count; ++j) {
      direction_[j] = is_free[j] != 0 ? Scalar(0) : static_cast<Scalar>(-z[j] / unit);
      any_moves = any_moves || direction_[j] != Scalar(0);
    }
    std::fill(image_.begin(), image_.end(), Scalar(0));
    if (any_moves) apply();
    for (std::size_t j = 0; j < count; ++j) {
      residual_[j] = is_free[j] != 0 ? static_cast<Scalar>(-gradient[j] / unit) - image_[j] : Scalar(0);
      direction_[j] = residual_[j];
      step_[j] = Scalar(0);
    }
    const std::size_t iterations = iterate(is_free, accuracy);
    for (std::size_t j = 0; j < count; ++j)
      direction[j] = is_free[j] != 0 ? unit * static_cast<double>(step_[j]) : -z[j];
    return iterations;
  }

 private:
  // image = scaled (G + ridge) x direction
  void apply() {
    const auto ridge = static_cast<Scalar>(problem_.ridge);
    const std::size_t count = scale_.size();
    for (std::size_t j = 0; j < count; ++j) unscaled_[j] = direction_[j] * scale_[j];
    apply_normal(problem_.equations, std::span<const Scalar>(unscaled_), std::span<Scalar>(image_));
    for (std::size_t j = 0; j < count; ++j) image_[j] = (image_[j] + ridge * unscaled_[j]) * scale_[j];
  }

  std::size_t iterate(const std::vector<std::uint8_t>& is_free, double accuracy) {
    const std::size_t count = scale_.size();
    double rho = dot_product(residual_, residual_);
    const double target = accuracy * accuracy * rho;
    std::size_t iterations = 0;
    while (rho > target && iterations < std::min(kInnerIterations, 200 + 2 * count)) {
      ++iterations;
      apply();
      for (std::size_t j = 0; j < count; ++j) image_[j] = is_free[j] != 0 ? image_[j] : Scalar(0);
      const double curvature = dot_product(direction_, image_);
      const double length = rho / curvature;
      if (!(curvature > 0.0) || !std::isfinite(length)) break;
      const auto alpha = static_cast<Scalar>(length);
      for (std::size_t j = 0; j < count; ++j) {
        step_[j] += alpha * direction_[j];
        residual_[j] -= alpha * image_[j];
      }
      const double next = dot_product(residual_, residual_);
      const auto beta = static_cast<Scalar>(next / rho);
      rho = next;
      for (std::size_t j = 0; j < count; ++j) direction_[j] = residual_[j] + beta * direction_[j];
    }
    return iterations;
  }

  const ScaledProblem& problem_;
  std::vector<Scalar> scale_;
  std::vector<Scalar> step_;
  std::vector<Scalar> residual_;
  std::vector<Scalar> direction_;
  std::vector<Scalar> unscaled_;
  std::vector<Scalar> image_;
};

// Where the search is, in scaled unknowns, and a trial point beside it.
struct Iterate {
  std::vector<double> z;
  std::vector<double> gradient;
  std::vector<double> trial;
  std::vector<double> trial_gradient;
};

// Goes to the clipped end of the direction, halving it until the objective falls. The change of the objective
// is half of (g + g_trial) . (trial - z), exact for a quadratic and free of its cancellation. Returns whether
// it moved.
bool take_step(ScaledProblem& problem, Iterate& at, const std::vector<double>& direction, int halvings) {
  double length = 1.0;
  for (int halving = 0; halving <= halvings; ++halving, length *= 0.5) {
    for (std::size_t j = 0; j < at.z.size(); ++j)
      at.trial[j] = std::max(0.0, at.z[j] + length * direction[j]);
    compute_gradient(problem, at.trial, at.trial_gradient);
    double slope = 0.0;
    double change = 0.0;
    for (std::size_t j = 0; j < at.z.size(); ++j) {
      const double moved = at.trial[j] - at.z[j];
      slope += at.gradient[j] * moved;
      change += 0.5 * (at.gradient[j] + at.trial_gradient[j]) * moved;
    }
    if (slope < 0.0 && change <= kSufficientDecrease * slope) {
      at.z.swap(at.trial);
      at.gradient.swap(at.trial_gradient);
      return true;
    }
  }
  return false;
}

// For problems so near singular that clipped steps stall: goes straight to the minimum on the free columns,
// or to the first bound in the way, whose columns stay there; again until nothing is in the way. Every part
// of it lowers the objective. `is_free` starts as the columns that are positive or pulled from their bound;
// one that the others push back at once stays at it.
template <typename Solver>
bool take_straight_steps(ScaledProblem& problem, Iterate& at, Solver& solver, std::vector<double>& direction,
                         NonnegativeReport& report) {
  const std::size_t count = at.z.size();
  std::vector<std::uint8_t> is_free(count);
  for (std::size_t j = 0; j < count; ++j) is_free[j] = at.z[j] > 0.0 || at.gradient[j] < 0.0 ? 1 : 0;
  bool moved = false;
  for (int part = 0; part < kStraightSteps && report.cg_iterations < kAllInnerIterations; ++part) {
    report.cg_iterations += solver.solve(at.z, at.gradient, is_free, kLastAccuracy, direction);
    double length = 1.0;
    for (std::size_t j = 0; j < count; ++j)
      if (direction[j] < 0.0) length = std::min(length, at.z[j] / -direction[j]);
    for (std::size_t j = 0; j < count; ++j) {
      const bool stops = direction[j] < 0.0 && at.z[j] + length * direction[j] <= 0.0;
      at.z[j] = stops ? 0.0 : std::max(0.0, at.z[j] + length * direction[j]);
      if (stops) is_free[j] = 0;
    }
    moved = moved || length > 0.0;
    if (length > 0.0) compute_gradient(problem, at.z, at.gradient);
    if (length == 1.0) break;
  }
  return moved;
}

double kkt_residual(const ScaledProblem& problem, const Iterate& at) {
  double residual = 0.0;
  for (std::size_t j = 0; j < at.z.size(); ++j)
    residual = std::max(residual, std::abs(std::min(at.z[j], at.gradient[j])));
  return residual / problem.size;
}

// Frees the columns that the gradient doesn't push to zero. Returns how many changed sides.
std::size_t choose_free(const Iterate& at, std::vector<std::uint8_t>& is_free) {
  std::size_t changed = 0;
  for (std::size_t j = 0; j < is_free.size(); ++j) {
    const std::uint8_t now = at.z[j] > at.gradient[j] ? 1 : 0;
    if (now != is_free[j]) ++changed;
    is_free[j] = now;
  }
  return changed;
}

ScaledProblem scale_problem(const NormalEquations& equations, std::span<const double> start,
                            const NonnegativeOptions& options) {
  const std::size_t count = start.size();
  require(equations.diagonal.size() == count && equations.linear.size() == count,
          "solve_nonnegative: the sizes of problem and start differ");
  require(options.toward.empty() || options.toward.size() == count,
          "solve_nonnegative: `toward` has another size");
  require(std::isfinite(options.ridge) && options.ridge >= 0.0,
          "solve_nonnegative: the ridge is finite and not negative");
  ScaledProblem problem{equations, options.ridge, {}, {}, 0.0, {}};
  problem.linear.resize(count);
  problem.inverse_scale.resize(count);
  problem.x.resize(count);
  for (std::size_t j = 0; j < count; ++j) {
    const double toward = options.toward.empty() ? 0.0 : options.toward[j];
    const double linear = equations.linear[j] + options.ridge * toward;
    const double diagonal = equations.diagonal[j] + options.ridge;
    require(std::isfinite(linear) && std::isfinite(diagonal) && diagonal >= 0.0 && std::isfinite(start[j]),
            "solve_nonnegative: problem and start are finite, squared column lengths not negative");
    problem.inverse_scale[j] = diagonal > 0.0 ? 1.0 / std::sqrt(diagonal) : 0.0;
    problem.linear[j] = linear * problem.inverse_scale[j];
    problem.size = std::max(problem.size, std::abs(problem.linear[j]));
  }
  return problem;
}

// Newton steps until the KKT residual is small enough. Where they bring too little, the inner solves get more
// accurate, and leave single precision when it has no more to give.
void minimize(ScaledProblem& problem, Iterate& at, const NonnegativeOptions& options,
              NonnegativeReport& report) {
  const std::size_t most = options.max_iterations > 0 ? options.max_iterations : kDefaultIterations;
  std::vector<std::uint8_t> is_free(at.z.size(), 1);
  std::vector<double> direction(at.z.size());
  bool in_single = static_cast<bool>(problem.equations.apply_single);
  std::optional<InnerSolver<float>> single;
  std::optional<InnerSolver<double>> full;
  if (in_single) single.emplace(problem);
  compute_gradient(problem, at.z, at.gradient);
  for (std::size_t j = 0; j < at.z.size(); ++j)
    require(std::isfinite(at.gradient[j]), "solve_nonnegative: the gradient at the start is not finite");
  report.kkt_relative = kkt_residual(problem, at);
  double accuracy = kFirstAccuracy;
  int patience = kPatience;
  while (report.kkt_relative > options.tolerance && report.iterations < most &&
         report.cg_iterations < kAllInnerIterations) {
    ++report.iterations;
    const bool same_set = choose_free(at, is_free) == 0;
    const double enough = kEnough * options.tolerance / report.kkt_relative;
    const double wanted = std::max(enough, same_set ? std::min(accuracy, kSettledAccuracy) : accuracy);
    if (!in_single && !full) full.emplace(problem);
    report.cg_iterations += in_single ? single->solve(at.z, at.gradient, is_free, wanted, direction)
                                      : full->solve(at.z, at.gradient, is_free, wanted, direction);
    bool moved = take_step(problem, at, direction, kHalvings);
    if (!moved) {
      for (std::size_t j = 0; j < at.z.size(); ++j) direction[j] = -at.gradient[j];
      moved = take_step(problem, at, direction, kGradientHalvings);
    }
    const double before = report.kkt_relative;
    report.kkt_relative = kkt_residual(problem, at);
    if (full && accuracy == kLastAccuracy && report.kkt_relative > 0.5 * before) {
      moved = take_straight_steps(problem, at, *full, direction, report) || moved;
      report.kkt_relative = kkt_residual(problem, at);
    }
    if (!moved && !in_single) break;
    const bool stalls = !moved || report.kkt_relative > 0.5 * before;
    patience = stalls ? patience - 1 : kPatience;
    if (!moved || patience <= 0) accuracy = std::max(0.1 * accuracy, kLastAccuracy);
    if (!moved || accuracy < kSingleAccuracy) in_single = false;
  }
}

}  // namespace

NonnegativeReport solve_nonnegative(const NormalEquations& equations, std::span<double> x,
                                    const NonnegativeOptions& options) {
  NonnegativeReport report;
  const std::size_t count = x.size();
  ScaledProblem problem = scale_problem(equations, x, options);
  if (problem.size == 0.0) {
    // The gradient at zero is zero: zero is a minimum.
    for (std::size_t j = 0; j < count; ++j) x[j] = problem.inverse_scale[j] > 0.0 ? 0.0 : std::max(0.0, x[j]);
    report.converged = true;
  } else {
    Iterate at{std::vector<double>(count), std::vector<double>(count), std::vector<double>(count),
               std::vector<double>(count)};
    for (std::size_t j = 0; j < count; ++j)
      if (problem.inverse_scale[j] > 0.0) at.z[j] = std::max(0.0, x[j] / problem.inverse_scale[j]);
    minimize(problem, at, options, report);
    for (std::size_t j = 0; j < count; ++j)
      x[j] = problem.inverse_scale[j] > 0.0 ? at.z[j] * problem.inverse_scale[j] : std::max(0.0, x[j]);
    report.converged = report.kkt_relative <= options.tolerance;
  }
  report.zeros = static_cast<std::size_t>(std::count(x.begin(), x.end(), 0.0));
  return report;
}

NonnegativeReport solve_nonnegative(const LinearMap& map, std::span<const double> rhs, std::span<double> x,
                                    const NonnegativeOptions& options) {
  require(rhs.size() == map.rows && x.size() == map.columns && map.column_norms_sq.size() == map.columns,
          "solve_nonnegative: the sizes of map, right-hand side and start differ");
  std::vector<double> image(map.rows);
  NormalEquations equations;
  equations.diagonal = map.column_norms_sq;
  equations.linear.resize(map.columns);
  map.apply_transposed(rhs, equations.linear);
  equations.apply = [&](std::span<const double> in, std::span<double> out) {
    map.apply(in, image);
    map.apply_transposed(image, out);
  };
  return solve_nonnegative(equations, x, options);
}

}  // namespace palpate::springs

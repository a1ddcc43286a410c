#include "core/springs/solvers/lbfgs.h"

#include <algorithm>
#include <cmath>
#include <deque>

#include "core/base/error.h"
#include "core/springs/solvers/sufficient_decrease.h"

namespace palpate::springs {
namespace {

constexpr int kMostTrials = 30;  // of the length of one step

struct Pair {
  std::vector<double> step;
  std::vector<double> change;  // of the gradient
  double inverse_product = 0.0;
};

double product(std::span<const double> a, std::span<const double> b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

// Minus the gradient times the quasi-Newton inverse Hessian: the two loops.
std::vector<double> descent_direction(const std::deque<Pair>& pairs, std::span<const double> gradient) {
  std::vector<double> direction(gradient.begin(), gradient.end());
  std::vector<double> alpha(pairs.size());
  for (std::size_t i = pairs.size(); i-- > 0;) {
    alpha[i] = pairs[i].inverse_product * product(pairs[i].step, direction);
    for (std::size_t j = 0; j < direction.size(); ++j) direction[j] -= alpha[i] * pairs[i].change[j];
  }
  const Pair& last = pairs.back();
  const double scale = 1.0 / (last.inverse_product * product(last.change, last.change));
  for (double& value : direction) value *= scale;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const double beta = pairs[i].inverse_product * product(pairs[i].change, direction);
    for (std::size_t j = 0; j < direction.size(); ++j) direction[j] += (alpha[i] - beta) * pairs[i].step[j];
  }
  for (double& value : direction) value = -value;
  return direction;
}

std::vector<double> first_direction(std::span<const double> gradient, double first_step) {
  double largest = 0.0;
  for (const double value : gradient) largest = std::max(largest, std::abs(value));
  std::vector<double> direction(gradient.begin(), gradient.end());
  for (double& value : direction) value *= -first_step / largest;
  return direction;
}

// The point where the search is, and the one that it tries.
struct Search {
  std::vector<double> trial;
  std::vector<double> gradient;
  std::vector<double> trial_gradient;
  double value = 0.0;
  double trial_value = 0.0;
};

// Shortens the step until f falls enough; each length from the parabola through what is known.
bool find_length(const SmoothFunction& f, const std::vector<double>& x, const std::vector<double>& direction,
                 Search& search, LbfgsReport& report) {
  const double slope = product(search.gradient, direction);
  if (!(slope < 0.0)) return false;
  double length = 1.0;
  for (int trial = 0; trial < kMostTrials; ++trial) {
    for (std::size_t j = 0; j < x.size(); ++j) search.trial[j] = x[j] + length * direction[j];
    search.trial_value = f(search.trial, search.trial_gradient);
    ++report.evaluations;
    if (search.trial_value <= search.value + kSufficientDecrease * length * slope) return true;
    const double excess = search.trial_value - search.value - length * slope;
    const double parabola = std::isfinite(excess) ? -0.5 * slope * length * length / excess : 0.0;
    length = std::clamp(parabola, 0.1 * length, 0.5 * length);
  }
  return false;
}

void keep_pair(const std::vector<double>& x, const Search& search, std::size_t memory,
               std::deque<Pair>& pairs) {
  Pair pair{std::vector<double>(x.size()), std::vector<double>(x.size()), 0.0};
  for (std::size_t j = 0; j < x.size(); ++j) {
    pair.step[j] = search.trial[j] - x[j];
    pair.change[j] = search.trial_gradient[j] - search.gradient[j];
  }
  const double curvature = product(pair.step, pair.change);
  const double sizes = product(pair.step, pair.step) * product(pair.change, pair.change);
  if (!(curvature > 1e-10 * std::sqrt(sizes))) return;
  pair.inverse_product = 1.0 / curvature;
  pairs.push_back(std::move(pair));
  if (pairs.size() > memory) pairs.pop_front();
}

}  // namespace

LbfgsReport minimize_lbfgs(const SmoothFunction& f, std::vector<double>& x, const LbfgsOptions& options) {
  LbfgsReport report;
  Search search{std::vector<double>(x.size()), std::vector<double>(x.size()), std::vector<double>(x.size()),
                0.0, 0.0};
  search.value = f(x, search.gradient);
  report.evaluations = 1;
  report.start_value = search.value;
  const double first_norm = std::sqrt(product(search.gradient, search.gradient));
  require(std::isfinite(search.value) && std::isfinite(first_norm),
          "minimize_lbfgs: the function is not finite at the start");
  report.gradient_norm = first_norm;
  report.stop = LbfgsStop::kIterations;
  std::deque<Pair> pairs;
  while (report.iterations < options.max_iterations) {
    if (report.gradient_norm <= options.gradient_tolerance * first_norm) {
      report.stop = LbfgsStop::kGradient;
      break;
    }
    std::vector<double> direction = pairs.empty() ? first_direction(search.gradient, options.first_step)
                                                  : descent_direction(pairs, search.gradient);
    if (!find_length(f, x, direction, search, report)) {
      report.stop = LbfgsStop::kNoDescent;
      if (pairs.empty()) break;
      pairs.clear();  // the memory misleads: once more along the gradient
      continue;
    }
    ++report.iterations;
    const double decrease = search.value - search.trial_value;
    keep_pair(x, search, options.memory, pairs);
    x.swap(search.trial);
    search.gradient.swap(search.trial_gradient);
    search.value = search.trial_value;
    report.stop = LbfgsStop::kIterations;
    report.gradient_norm = std::sqrt(product(search.gradient, search.gradient));
    if (decrease <= options.decrease_tolerance * std::abs(search.value)) {
      report.stop = LbfgsStop::kDecrease;
      break;
    }
  }
  report.value = search.value;
  return report;
}

}  // namespace palpate::springs

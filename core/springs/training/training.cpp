#include "core/springs/training/training.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/error.h"
#include "core/springs/training/network_equilibrium.h"

namespace palpate::springs {
namespace {

std::size_t term_count(const RankOneTerms& terms) {
  return terms.constant.size();
}

void check_shapes(const RankOneTerms& terms, const TrainingSet& set) {
  const std::size_t components = set.weight.size();
  require(terms.offsets.size() == terms.constant.size() + 1 &&
              terms.offsets.back() == terms.component.size() &&
              terms.component.size() == terms.coefficient.size(),
          "training: the terms' arrays fit each other");
  for (const Index component : terms.component)
    require(component < components, "training: a term names a component that does not exist");
  for (const double value : terms.constant)
    require(value > 0.0 && std::isfinite(value), "training: constants to start from are positive");
  for (const TrainingBoundary& boundary : set.boundaries) {
    require(boundary.held.size() == components, "training: one held flag a component");
    for (const StiffnessEntry& entry : boundary.stiffness)
      require(entry.row < components && entry.column < components,
              "training: a stiffness entry names a component that does not exist");
  }
  for (const TrainingCase& one : set.cases)
    require(one.boundary < set.boundaries.size() && one.force_n.size() == components &&
                one.held_m.size() == components && one.target_m.size() == components,
            "training: a case has one force, held displacement and target a component");
}

// |t|_w^2. Throws: InputError if it is zero.
double target_size(const TrainingSet& set, const TrainingCase& one) {
  double size = 0.0;
  for (std::size_t i = 0; i < set.weight.size(); ++i)
    size += set.weight[i] * one.target_m[i] * one.target_m[i];
  if (!(size > 0.0) || !std::isfinite(size))
    throw InputError("training case '" + one.name + "': expected a displacement to learn from, found none");
  return size;
}

double squared_error(const TrainingSet& set, const TrainingCase& one, std::span<const double> u) {
  double sum = 0.0;
  for (std::size_t i = 0; i < u.size(); ++i)
    sum += set.weight[i] * (u[i] - one.target_m[i]) * (u[i] - one.target_m[i]);
  return sum / target_size(set, one);
}

// Adds the gradient of one case's share of J: with lambda the adjoint, -c_q (d_q . u)(d_q . lambda).
void add_case_gradient(const RankOneTerms& terms, std::span<const double> constant, std::span<const double> u,
                       std::span<const double> lambda, std::span<double> gradient) {
  for (std::size_t q = 0; q < term_count(terms); ++q) {
    double along = 0.0;
    double adjoint = 0.0;
    for (std::size_t i = terms.offsets[q]; i < terms.offsets[q + 1]; ++i) {
      along += terms.coefficient[i] * u[terms.component[i]];
      adjoint += terms.coefficient[i] * lambda[terms.component[i]];
    }
    gradient[q] -= constant[q] * along * adjoint;
  }
}

// The equilibria of a training set, built once and solved for many constants.
class Fit {
 public:
  Fit(const RankOneTerms& terms, const TrainingSet& set) : terms_(terms), set_(set) {
    check_shapes(terms, set);
    for (const TrainingBoundary& boundary : set.boundaries) equilibria_.emplace_back(terms, boundary);
    for (const double constant : terms.constant) start_.push_back(std::log(constant));
  }

  const std::vector<double>& start() const { return start_; }

  // Returns the first case whose stiffness is not positive definite, or the number of cases.
  std::size_t factor(std::span<const double> constant) {
    std::vector<bool> is_definite;
    for (NetworkEquilibrium& equilibrium : equilibria_) is_definite.push_back(equilibrium.factor(constant));
    for (std::size_t i = 0; i < set_.cases.size(); ++i)
      if (!is_definite[set_.cases[i].boundary]) return i;
    return set_.cases.size();
  }

  std::vector<double> solve(const TrainingCase& one) const {
    return equilibria_[one.boundary].solve(one.force_n, one.held_m);
  }

  // J at theta, and its gradient; infinite where the stiffness is singular to rounding.
  double evaluate(double ridge, std::span<const double> theta, std::span<double> gradient) {
    std::vector<double> constant(theta.size());
    std::transform(theta.begin(), theta.end(), constant.begin(), [](double t) { return std::exp(t); });
    std::fill(gradient.begin(), gradient.end(), 0.0);
    for (const double value : constant)
      if (!(value > 0.0) || !std::isfinite(value)) return std::numeric_limits<double>::infinity();
    if (factor(constant) < set_.cases.size()) return std::numeric_limits<double>::infinity();
    const auto cases = static_cast<double>(set_.cases.size());
    double objective = 0.0;
    std::vector<double> pull(set_.weight.size());
    for (const TrainingCase& one : set_.cases) {
      const std::vector<double> u = solve(one);
      objective += squared_error(set_, one, u) / cases;
      const double scale = 2.0 / (cases * target_size(set_, one));
      for (std::size_t i = 0; i < u.size(); ++i) pull[i] = scale * set_.weight[i] * (u[i] - one.target_m[i]);
      add_case_gradient(terms_, constant, u, equilibria_[one.boundary].solve_adjoint(pull), gradient);
    }
    const double share = ridge / static_cast<double>(theta.size());
    for (std::size_t q = 0; q < theta.size(); ++q) {
      const double moved = theta[q] - start_[q];
      objective += share * moved * moved;
      gradient[q] += 2.0 * share * moved;
    }
    return objective;
  }

 private:
  const RankOneTerms& terms_;
  const TrainingSet& set_;
  std::vector<NetworkEquilibrium> equilibria_;
  std::vector<double> start_;
};

double root_mean_square(const std::vector<CaseResult>& results) {
  double sum = 0.0;
  for (const CaseResult& result : results) sum += result.relative_error * result.relative_error;
  return std::sqrt(sum / static_cast<double>(results.size()));
}

}  // namespace

std::vector<CaseResult> solve_cases(const RankOneTerms& terms, std::span<const double> constant,
                                    const TrainingSet& set) {
  require(constant.size() == term_count(terms), "training: one constant a term");
  Fit fit(terms, set);
  const std::size_t singular = fit.factor(constant);
  if (singular < set.cases.size())
    throw InputError("training case '" + set.cases[singular].name +
                     "': expected supports or clamps that leave no motion free, found one that is");
  std::vector<CaseResult> results;
  for (const TrainingCase& one : set.cases) {
    CaseResult result{fit.solve(one), 0.0};
    result.relative_error = std::sqrt(squared_error(set, one, result.displacement_m));
    results.push_back(std::move(result));
  }
  return results;
}

double training_objective(const RankOneTerms& terms, const TrainingSet& set, double ridge,
                          std::span<const double> theta, std::span<double> gradient) {
  require(theta.size() == term_count(terms) && gradient.size() == theta.size(),
          "training: one unknown a term");
  return Fit(terms, set).evaluate(ridge, theta, gradient);
}

TrainingReport fit_constants(const RankOneTerms& terms, const TrainingSet& set,
                             const TrainingOptions& options) {
  require(!set.cases.empty() && term_count(terms) > 0, "training: at least one case and one term");
  require(options.ridge >= 0.0 && std::isfinite(options.ridge), "training: the ridge is not negative");
  TrainingReport report;
  report.error_before = root_mean_square(solve_cases(terms, terms.constant, set));
  Fit fit(terms, set);
  std::vector<double> theta = fit.start();
  const auto evaluate = [&](std::span<const double> at, std::span<double> gradient) {
    if (options.before_evaluation) options.before_evaluation();
    return fit.evaluate(options.ridge, at, gradient);
  };
  report.lbfgs = minimize_lbfgs(evaluate, theta, options.lbfgs);
  for (const double value : theta) report.constant.push_back(std::exp(value));
  report.error_after = root_mean_square(solve_cases(terms, report.constant, set));
  return report;
}

}  // namespace palpate::springs

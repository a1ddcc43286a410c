// Constants trained on displacement fields: positive spring constants, and moduli of a volume model where
// there is one, that bring the equilibria of a linear network near fields that are given.
//
// The energy is a sum of rank-one terms with one constant each, and of what isn't trained:
//
//   W(u) = 1/2 sum over q of c_q (d_q . u)^2 + 1/2 u . B u - f . u,     c_q = exp(theta_q) > 0
//
// A spring is such a term, d = (e, -e); so is the dilatation of a vertex or of a tet. B holds elastic
// supports and the fixed part of a material; it may differ from case to case, and so may the held components.
// The fit minimises
//
//   J(theta) = mean over cases of |u - t|_w^2 / |t|_w^2 + ridge x mean over q of (theta_q - theta0_q)^2,
//
// by L-BFGS with adjoint gradients: K lambda = dJ/du, dJ/dtheta_q = -c_q (d_q . u)(d_q . lambda).
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "core/springs/solvers/lbfgs.h"
#include "core/springs/training/training_terms.h"

namespace palpate::springs {

/// A load and the field that it should give. Shape: one entry a component; held_m counts where it is held.
struct TrainingCase {
  std::string name;
  std::size_t boundary = 0;
  std::vector<double> force_n;
  std::vector<double> held_m;
  std::vector<double> target_m;
};

/// Cases on one mesh. `weight` holds one positive weight a component (its share of the volume).
struct TrainingSet {
  std::vector<double> weight;
  std::vector<TrainingBoundary> boundaries;
  std::vector<TrainingCase> cases;
};

/// The equilibrium of each case and its error sqrt(|u - t|_w^2 / |t|_w^2).
struct CaseResult {
  std::vector<double> displacement_m;
  double relative_error = 0.0;
};

/// Solves all cases with the constants given (one a term).
/// Throws: InputError that names the case if its stiffness is singular (it can move freely) or its target
///         is zero; ContractError for shapes that don't fit.
std::vector<CaseResult> solve_cases(const RankOneTerms& terms, std::span<const double> constant,
                                    const TrainingSet& set);

/// The weight of the prior, and how the objective is minimised.
struct TrainingOptions {
  double ridge = 0.0;
  LbfgsOptions lbfgs;
  std::function<void()> before_evaluation;  ///< if there is one; what it throws ends the fit
};

/// The fitted constants, and how well they fit.
struct TrainingReport {
  std::vector<double> constant;  ///< one a term
  LbfgsReport lbfgs;
  double error_before = 0.0;  ///< root mean square of the relative errors over the cases
  double error_after = 0.0;
};

/// J and its gradient at theta. For tests and for fit_constants.
double training_objective(const RankOneTerms& terms, const TrainingSet& set, double ridge,
                          std::span<const double> theta, std::span<double> gradient);

/// Fits the constants from their start. Deterministic.
/// Throws: as solve_cases.
TrainingReport fit_constants(const RankOneTerms& terms, const TrainingSet& set,
                             const TrainingOptions& options);

}  // namespace palpate::springs

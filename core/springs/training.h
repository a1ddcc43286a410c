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

#include "core/mesh/spring_network.h"
#include "core/mesh/tet_mesh.h"
#include "core/springs/lbfgs.h"

namespace palpate::springs {

/// Rank-one terms in compressed rows. Component 3 v + axis belongs to vertex v.
///
/// Shape:  term q is the sum over i in [offsets[q], offsets[q + 1]) of coefficient[i] u[component[i]], each
///         component once; `constant` holds one positive start a term (c_q at theta0).
struct RankOneTerms {
  std::vector<std::size_t> offsets{0};
  std::vector<Index> component;
  std::vector<double> coefficient;
  std::vector<double> constant;
};

/// Adds a term 1/2 k (e . (u_b - u_a))^2 for each spring. Springs of a stiffness below `least_share` of the
/// mean start there: a constant of zero has no logarithm. In N/m.
void add_spring_terms(const TetMesh& mesh, const SpringNetwork& network, double least_share,
                      RankOneTerms& terms);

/// Adds a term 1/2 V_n m_n (tr eps_n)^2 for each vertex, eps_n the mean strain of its tets weighted by
/// volume, V_n a quarter of their volume: node-averaged dilatation. In Pa; m_n = `modulus_pa` > 0 at the
/// start.
void add_vertex_dilatation_terms(const TetMesh& mesh, double modulus_pa, RankOneTerms& terms);

/// Adds a term 1/2 V_T m_T (tr eps_T)^2 for each tet. In Pa.
void add_tet_dilatation_terms(const TetMesh& mesh, double modulus_pa, RankOneTerms& terms);

/// An entry of a symmetric matrix; both (i, j) and (j, i) are given. Equal places add up.
struct StiffnessEntry {
  Index row = 0;
  Index column = 0;
  double value_n_per_m = 0.0;
};

/// What holds the body in one or more cases: B, and the components that are prescribed (1) or free (0).
struct TrainingBoundary {
  std::vector<StiffnessEntry> stiffness;
  std::vector<std::uint8_t> held;
};

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

struct TrainingOptions {
  double ridge = 0.0;
  LbfgsOptions lbfgs;
  std::function<void()> before_evaluation;  ///< if there is one; what it throws ends the fit
};

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

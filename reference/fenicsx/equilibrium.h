// Static equilibrium of a held and loaded body.
#pragma once

#include <string>

#include "reference/fenicsx/linear_solver.h"

namespace palpate::reference::fenicsx {

struct EquilibriumOptions {
  SolverChoice solver = SolverChoice::kAuto;
  double tolerance_relative = 1e-10;  ///< of the residual, over that of the undeformed body under all load
  int most_newton_steps = 30;         ///< a load step; large strain alone
  int most_load_steps = 64;           ///< large strain alone
};

/// What was found. The displacement is in the body's own order, with ghosts up to date.
struct Equilibrium {
  std::string outcome;  ///< "converged" or "not_converged"
  Vector displacement;
  std::string solver;
  int linear_iterations = 0;
  int newton_steps = 0;
  int load_steps = 0;
  double residual_relative = 0.0;
  double strain_energy_j = 0.0;
  double support_energy_j = 0.0;
  double assembly_s = 0.0;
  double solve_s = 0.0;
};

/// Small strain: one linear solve. Large strain: load steps, each with Newton's method and a line search on
/// the total energy; a load step that fails is halved.
Equilibrium find_equilibrium(const TetMesh& mesh, const BoundaryProblem& problem, ElasticBody& body,
                             const EquilibriumOptions& options);

}  // namespace palpate::reference::fenicsx

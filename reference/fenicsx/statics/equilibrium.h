// Static equilibrium of a held and loaded body.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "reference/fenicsx/statics/linear_solver.h"

namespace palpate::reference::fenicsx {

struct EquilibriumOptions {
  SolverChoice solver = SolverChoice::kAuto;
  double tolerance_relative = 1e-10;  ///< of the force out of balance, over that of the undeformed body
  int most_newton_steps = 20;         ///< for one load step; large strain alone
  double least_load_step = 1.0 / 1024.0;
};

/// What was found. The displacement is in the body's own order, with ghosts up to date.
struct Equilibrium {
  std::string outcome;  ///< "converged" or "not_converged"
  Vector displacement;
  std::string solver;
  int linear_iterations = 0;
  int newton_steps = 0;  ///< linear systems solved
  int load_steps = 0;
  double residual_relative = 0.0;
  double strain_energy_j = 0.0;
  double support_energy_j = 0.0;
  std::vector<Vec3> support_forces_n;  ///< of each support on the body, in the problem's order
  double assembly_s = 0.0;
  double solve_s = 0.0;
};

/// Small strain: one linear solve. Large strain: all load at once and then, where that fails, in smaller load
/// steps; each by Newton's method with a line search on the total energy.
///
/// All problems share_stiffness with the first: its tangent is assembled and factored once. One equilibrium a
/// problem; times are each one's own, and the first has the assembly.
std::vector<Equilibrium> find_equilibria(const TetMesh& mesh, std::span<const BoundaryProblem> problems,
                                         ElasticBody& body, const EquilibriumOptions& options);

/// Whether two problems on one mesh differ in their loads alone: the same material, small strain, the same
/// supports wherever they stand, and nothing that is held moves.
bool share_stiffness(const BoundaryProblem& a, const BoundaryProblem& b);

}  // namespace palpate::reference::fenicsx

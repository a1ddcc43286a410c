// Static equilibrium of an elastic model: Newton's method with a line search, or one linearised solve.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/dynamics/elasticity/elastic_model.h"
#include "core/dynamics/elasticity/loads.h"
#include "core/dynamics/linear_algebra/linear_solver.h"

namespace palpate::dynamics {

/// How a search for equilibrium ended; only kConverged is an answer.
enum class StaticOutcome {
  kConverged,     ///< a stable equilibrium, every tet positive
  kBuckled,       ///< an equilibrium that is not stable: its tangent is not positive definite
  kInverted,      ///< an equilibrium with tets that are not positive
  kDiverged,      ///< displacements that are not finite, or beyond any bound
  kNotConverged,  ///< out of iterations or of load steps
};

/// "converged", "buckled", "inverted", "diverged" or "not_converged".
const char* static_outcome_name(StaticOutcome outcome);

/// How Newton's method goes, and when it is done.
struct StaticOptions {
  bool linearised = false;           ///< one solve with the tangent at rest
  int load_steps = 1;                ///< loads and held displacements grow in so many equal steps
  int max_halvings = 4;              ///< a step that fails is tried again at half its size, so many times
  double tolerance = 1e-9;           ///< of residual_relative
  std::size_t max_iterations = 150;  ///< Newton's, a load step
  LinearOptions linear;
};

/// What became of a search for an equilibrium.
struct StaticReport {
  StaticOutcome outcome = StaticOutcome::kNotConverged;
  std::size_t iterations = 0;         ///< Newton's, all load steps
  std::size_t linear_iterations = 0;  ///< of conjugate gradients; 0 if all solves were factorisations
  std::size_t load_steps = 0;         ///< taken, halved ones too
  std::size_t indefinite_tangents = 0;
  double residual_relative = 0.0;  ///< |free forces| / (|loads| + |support forces| + |reactions|)
  double elastic_energy_j = 0.0;
  double potential_j = 0.0;  ///< elastic energy + energy of the supports - work of the dead loads
  std::size_t inverted_tets = 0;
  double least_volume_ratio = 1.0;  ///< smallest deformed / rest volume of a tet
  std::vector<double> residuals;    ///< residual_relative at each iterate of the last load step
};

/// The displacement that was found, with its report.
struct StaticSolution {
  std::vector<Vec3> displacement_m;  ///< one a vertex, finite; zero where the outcome is kDiverged
  StaticReport report;
};

/// Finds u with elastic + load + support forces = 0 at every free component.
///
/// Newton's method on the potential with the exact tangent; where that is indefinite, with the one whose
/// springs and domains are made semidefinite one by one. Steps are halved until the potential falls as
/// Armijo's rule asks. A model with a volume force has no potential: there the residual must fall, and the
/// low-rank part of the tangent is taken in by Woodbury's formula.
///
/// Throws: InputError if a rigid motion is left free (require_no_rigid_motion).
StaticSolution solve_static(const TetMesh& mesh, const ElasticModel& model, const Loads& loads,
                            const StaticOptions& options);

}  // namespace palpate::dynamics

// Motion of a linear elastic body: Newmark's method of average acceleration.
#pragma once

#include <string>

#include "reference/door/motion_problem.h"
#include "reference/fenicsx/motion/moving_body.h"
#include "reference/fenicsx/statics/linear_solver.h"

namespace palpate::reference::fenicsx {

struct NewmarkOptions {
  double time_step_s = 1e-3;
  SolverChoice solver = SolverChoice::kAuto;  ///< kGamg: conjugate gradients, preconditioned node by node
  double tolerance_relative = 1e-10;          ///< residual of each step over the force that it has to balance
};

/// What was found.
struct Motion {
  std::string outcome;  ///< "completed" or "not_converged"
  MotionHistory history;
  MotionStates states;  ///< at the mesh's vertices
  std::string solver;
  std::uint64_t steps = 0;
  std::uint64_t linear_iterations = 0;
  double time_step_s = 0.0;        ///< the longest one taken
  double residual_relative = 0.0;  ///< the worst of all steps
  double assembly_s = 0.0;
  double solve_s = 0.0;
};

/// Integrates M a + C v + K u = f(t) from rest, C = alpha M + beta K, with Newmark's method for beta = 1/4
/// and gamma = 1/2:
///
///   u' = u + h v + h^2/4 (a + a'),  v' = v + h/2 (a + a'),  M a' + C v' + K u' = f(t')
///
/// It is of second order, stable for any step, and keeps the energy of a linear body to rounding: nothing is
/// damped but by C. Held entries follow their profiles exactly, in displacement, velocity and acceleration.
/// Each phase of the loads is divided into equal steps of at most `time_step_s` and starts from the
/// acceleration that its forces give. Source: N. M. Newmark, J. Eng. Mech. Div. ASCE 85 (1959).
///
/// Throws: InputError for large strain, or if a load holds what another one holds.
Motion find_motion(const TetMesh& mesh, const MotionProblem& problem, ElasticBody& body,
                   const NewmarkOptions& options);

}  // namespace palpate::reference::fenicsx

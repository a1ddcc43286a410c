// One linearised step of backward Euler; see core/dynamics/integrators/integrator.h.
#pragma once

#include <span>
#include <vector>

#include "core/dynamics/integrators/step_balance.h"
#include "core/dynamics/linear_algebra/block_matrix.h"
#include "core/dynamics/linear_algebra/linear_solver.h"
#include "core/dynamics/motion/motion_forces.h"

namespace palpate::dynamics {

/// One linearised step of backward Euler.
class LinearisedStep {
 public:
  LinearisedStep(const MotionForces& forces, const LinearOptions& options);

  /// The velocities after a step from `state`; those of held components are (u(t + h) - u) / h.
  ImplicitResult find_velocity(MotionForces& forces, const MotionState& state, double step_s,
                               std::span<Vec3> velocity);

 private:
  /// Assembles the system at the state and readies the solver; once for each step's length in a linear body.
  void prepare(const MotionForces& forces, const MotionState& state, double step_s);

  bool is_linear_;
  bool is_definite_ = false;
  double prepared_step_s_ = 0.0;
  BlockMatrix pattern_;   ///< zero
  BlockMatrix constant_;  ///< damping that never changes
  BlockMatrix stiffness_;
  BlockMatrix system_;
  LinearSolver solver_;
  std::vector<Vec3> force_;
  std::vector<Vec3> product_;
  std::vector<Vec3> change_;
};

}  // namespace palpate::dynamics

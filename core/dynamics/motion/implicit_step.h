// The two implicit integrators' steps; see core/dynamics/motion/integrator.h.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/dynamics/linear_algebra/block_matrix.h"
#include "core/dynamics/linear_algebra/linear_solver.h"
#include "core/dynamics/motion/motion_forces.h"

namespace palpate::dynamics {

/// What a solve for the next velocities came to.
struct ImplicitResult {
  std::size_t zero_length_springs = 0;
  std::size_t iterations = 0;
  bool solved = true;
};

/// One linearised step of backward Euler.
class LinearisedStep {
 public:
  LinearisedStep(const MotionForces& forces, const LinearOptions& options);

  /// The velocities after a step from `state`; those of held components are (u(t + h) - u) / h.
  ImplicitResult find_velocity(MotionForces& forces, const MotionState& state, double step_s,
                               std::span<Vec3> velocity);

 private:
  BlockMatrix pattern_;   ///< zero
  BlockMatrix constant_;  ///< damping that never changes
  BlockMatrix stiffness_;
  BlockMatrix system_;
  LinearSolver solver_;
  std::vector<Vec3> force_;
  std::vector<Vec3> product_;
  std::vector<Vec3> change_;
};

/// Backward Euler by iterations with a matrix that is factored once for each step size.
class PrefactoredStep {
 public:
  /// Throws: InputError for a model with strain terms or a volume force.
  PrefactoredStep(const MotionForces& forces, std::size_t iterations, double tolerance);
  ~PrefactoredStep();
  PrefactoredStep(PrefactoredStep&&) noexcept;
  PrefactoredStep& operator=(PrefactoredStep&&) noexcept;

  /// As LinearisedStep::find_velocity.
  ImplicitResult find_velocity(MotionForces& forces, const MotionState& state, double step_s,
                               std::span<Vec3> velocity);

 private:
  struct Factors;
  std::unique_ptr<Factors> factors_;
  std::size_t iterations_;
  double tolerance_;
};

}  // namespace palpate::dynamics

// Backward Euler by iterations with one matrix that is factored once: projective dynamics.
#pragma once

#include <memory>

#include "core/dynamics/integrators/step_balance.h"
#include "core/dynamics/motion/motion_forces.h"

namespace palpate::dynamics {

/// (u' - u - h v) m / h^2 = f(u', (u' - u) / h, t + h), iterated by u' += A^-1 (f - m a) with
///
///   A = M / h^2 + gamma / h + Laplacian of (k + c / h) + sum over domains (1 + b / h) V w g_a . g_b +
///   supports, w = 2 mu + lambda (2 mu where lambda < 0)
///
/// which serves all three components. Of springs it is the local-global iteration: what the local step finds
/// of each spring alone is put together by one linear solve. Of strain energies A is that of 2 mu |F - R|^2 /
/// 2 and of a dilatation that acts along each axis alike; where a correction leaves more out of balance than
/// there was, it is halved.
///
/// Source: T. Liu, A. Bargteil, J. O'Brien and L. Kavan, ACM Trans. Graph. 32 (2013); S. Bouaziz et al., ACM
/// Trans. Graph. 33 (2014); as a quasi-Newton method for any energy: T. Liu, S. Bouaziz and L. Kavan, ACM
/// Trans. Graph. 36 (2017).
class PrefactoredStep {
 public:
  /// Throws: InputError for a model with the thesis's volume force, which has no energy.
  PrefactoredStep(const MotionForces& forces, const StepSolverOptions& options);
  ~PrefactoredStep();
  PrefactoredStep(PrefactoredStep&&) noexcept;
  PrefactoredStep& operator=(PrefactoredStep&&) noexcept;

  /// Moves the displacements `u` from the state to the end of the step.
  ImplicitResult find_displacement(MotionForces& forces, const MotionState& state, double step_s,
                                   std::span<Vec3> u);

 private:
  struct Work;
  std::unique_ptr<Work> work_;
};

}  // namespace palpate::dynamics

// Backward Euler by iterations with one matrix that is factored once: projective dynamics.
#pragma once

#include <memory>

#include "core/dynamics/integrators/step_balance.h"
#include "core/dynamics/motion/motion_forces.h"

namespace palpate::dynamics {

/// (u' - u - h v) m / h^2 = f(u', (u' - u) / h, t + h), iterated by u' += H (f - m a), where H is A^-1 bent
/// to what the last corrections have shown (CurvaturePairs; those of earlier steps of the same length too),
/// and
///
///   A = M / h^2 + gamma / h + Laplacian of (k + c / h) + sum over domains (1 + b / h) V w g_a . g_b +
///   supports, w = 2 mu + 3/2 lambda (2 mu where lambda < 0)
///
/// which serves all three components. Of springs A is that of the local-global iteration: what the local step
/// finds of each spring alone is put together by one linear solve. Of an isotropic strain energy the
/// stiffness lies between 2 mu (a change of shape) and 2 mu + 3 lambda (of volume alone); w is the middle,
/// and half of the greatest is below it for every lambda, so that of a linear body A^-1 alone comes nearer
/// each time. A correction that ends well beyond where its slope is zero is shortened to there. With
/// `tolerance` 0 the last correction of a step is looked at only where an earlier one of the step was too
/// long.
///
/// Source: T. Liu, A. Bargteil, J. O'Brien and L. Kavan, ACM Trans. Graph. 32 (2013); S. Bouaziz et al., ACM
/// Trans. Graph. 33 (2014); as a quasi-Newton method for any energy, with memory: T. Liu, S. Bouaziz and
/// L. Kavan, ACM Trans. Graph. 36 (2017), who look at the energy where this looks at the slope (dampers have
/// no energy), and forget at the end of a step.
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

// Steps of backward Euler, BDF2 and the trapezoidal rule, each solved by Newton's method.
#pragma once

#include <memory>

#include "core/dynamics/integrators/step_balance.h"
#include "core/dynamics/linear_algebra/linear_solver.h"
#include "core/dynamics/motion/motion_forces.h"

namespace palpate::dynamics {

/// How velocity and acceleration at the end of a step follow from the displacement there:
/// v' = r (u' - u*), a' = r (v' - v*), and m a' = f(u', v', t').
///
///   kBackwardEuler  r = 1 / h,    u* = u,                      v* = v
///   kBdf2           r = 3 / (2h), u* = (4 u - u_before) / 3,   v* = (4 v - v_before) / 3
///   kTrapezoidal    r = 2 / h,    u* = u + h/2 v,              v* = v + h/2 a
///
/// The last one is Newmark's method with constant average acceleration (beta 1/4, gamma 1/2). The first step
/// of kBdf2, and the first after the caller has changed state or step, is one of backward Euler: the order
/// stays 2, and fast motions start as damped as they go on.
/// Source: N. Newmark, J. Eng. Mech. Div. ASCE 85 (1959); C. Curtiss and J. Hirschfelder, PNAS 38 (1952).
enum class ImplicitRule { kBackwardEuler, kBdf2, kTrapezoidal };

/// Solves each step by Newton's method on f - m a = 0 with the matrix r^2 M + r D + K:
///
///   - the exact tangent, or, where a factorisation finds it indefinite, the one whose springs and domains
///     are made semidefinite one by one;
///   - a step of Newton's is halved, up to 20 times, until the forces out of balance shrink;
///   - a linear body (springs at rest directions, linear laws, no volume force) has its matrix factored once
///     for each r.
///
/// The guess to start from is u + h v, or u + h v + h^2/2 a with the last step's acceleration where that has
/// less out of balance. Of the damping's dependence on u and of the thesis's volume force the matrix knows
/// nothing; they cost iterations, not accuracy.
class NewtonStep {
 public:
  NewtonStep(const MotionForces& forces, ImplicitRule rule, const StepSolverOptions& options,
             const LinearOptions& linear);
  ~NewtonStep();
  NewtonStep(NewtonStep&&) noexcept;
  NewtonStep& operator=(NewtonStep&&) noexcept;

  /// Moves displacements and velocities on by one step; the time stays. Held components follow their
  /// profiles; while kBackwardEuler solves, their velocities are (u' - u) / h, and the profiles' otherwise.
  ImplicitResult take(MotionForces& forces, MotionState& state, double step_s);

 private:
  struct Work;
  std::unique_ptr<Work> work_;
};

}  // namespace palpate::dynamics

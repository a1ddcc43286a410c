// Backward Euler by sweeps over springs, domains and supports, each solved for its own multiplier: XPBD.
#pragma once

#include <memory>

#include "core/dynamics/integrators/step_balance.h"
#include "core/dynamics/motion/motion_forces.h"
#include "core/dynamics/position_kernel/position_rows.h"

namespace palpate::dynamics {

/// Extended position-based dynamics. Every energy 1/2 c . K c with damping b c' . K c' / 2 has a multiplier l
/// = -(h^2 K c + h b K (c - c_before)) that a sweep corrects with the others as they stand,
///
///   dl = -(1 + (h^2 + h b) K G)^-1 (l + h^2 K c + h b K (c - c_before)),   G = grad c W grad c^T,
///   u' += W grad c^T dl,   W = 1 / (m + h gamma), 0 where held,
///
/// from u' = u + h W (m v + h f), f the dead loads; l starts at zero. c is
///
///   of a spring          |d| - L, or e . du of a linearised one; K = k, b K = its damping
///   of a domain          the six strains of sym(R^T (F - R)), R the polar rotation (I for the linear law),
///                        solved together with K = V (lambda, mu); R is held while the domain is solved;
///                        of kStableNeoHookean two, of shape and volume (neo_hookean_constraints.h)
///   of a support's face  what its three corners move, in the three modes of its mass
///
/// A linear body's sweeps converge to NewtonStep's step of backward Euler. Where the gradients turn while the
/// multipliers build up, what it converges to is not quite that: the part of the momentum that a correction
/// gave along an earlier direction stays, and some forces stay out of balance however long it sweeps. The
/// constraints of kStableNeoHookean take it back.
///
/// Springs and domains are coloured in the order of the model, so that those of one colour share no vertex,
/// and are solved eight at a time, colour after colour (core/dynamics/position_kernel); behind the colours
/// come, one at a time, those with a vertex that is held along some axes alone, and the supports. Every
/// second sweep goes backwards. It uses one thread.
///
/// Source: M. Macklin, M. Mueller and N. Chentanez, XPBD, MIG 2016; small steps: M. Macklin et al., SCA 2019.
class PositionStep {
 public:
  /// Throws: InputError for what has no energy of that form: the thesis's volume force, isotropic damping,
  /// the neo-Hookean law with a logarithm.
  PositionStep(const MotionForces& forces, const StepSolverOptions& options,
               PositionKernel kernel = PositionKernel::kBest);
  ~PositionStep();
  PositionStep(PositionStep&&) noexcept;
  PositionStep& operator=(PositionStep&&) noexcept;

  /// Moves the displacements `u` from the state to the end of the step.
  ImplicitResult find_displacement(MotionForces& forces, const MotionState& state, double step_s,
                                   std::span<Vec3> u);

 private:
  struct Work;
  std::unique_ptr<Work> work_;
};

}  // namespace palpate::dynamics

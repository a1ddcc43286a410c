// Time integrators of a moving body.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>

#include "core/dynamics/integrators/step_balance.h"
#include "core/dynamics/linear_algebra/linear_solver.h"
#include "core/dynamics/motion/integrator_kind.h"
#include "core/dynamics/motion/motion_forces.h"

namespace palpate::dynamics {

/// Which integrator, and how it solves where it has to.
struct IntegratorOptions {
  IntegratorKind kind = IntegratorKind::kSymplecticEuler;
  int threads = 1;
  double speed_limit_m_s =
      0.0;                   ///< longer velocities are cut to this, but those of held vertices; 0: no limit
  LinearOptions linear;      ///< kImplicitEuler and those that are solved by Newton's method
  StepSolverOptions solver;  ///< of those that iterate within a step: all implicit ones but kImplicitEuler
  std::size_t substeps = 1;  ///< kXpbd, kVbd: each step is taken as so many
};

/// What happened in one step.
struct StepReport {
  std::size_t zero_length_springs = 0;  ///< over all force evaluations
  std::size_t speeds_cut = 0;           ///< vertices whose speed was cut to the limit
  std::size_t iterations = 0;           ///< of the linear or nonlinear solver
  bool solved = true;                   ///< whether the solver came to its tolerance
  /// Forces out of balance that the solver left, over those of the inertial guess; where it was measured.
  std::optional<double> residual_relative;
};

/// Steps one body. The result doesn't depend on the number of threads.
class Integrator {
 public:
  /// `model` must outlive this. Throws: as validate(MotionModel); InputError for a negative speed limit, and
  /// for kPrefactored, kXpbd and kVbd with a model that they cannot take.
  Integrator(const MotionModel& model, const IntegratorOptions& options);
  ~Integrator();
  Integrator(Integrator&&) noexcept;
  Integrator& operator=(Integrator&&) noexcept;

  /// Moves `state` on by `step_s` > 0. A state that is not finite any more is left as it comes out.
  StepReport step(MotionState& state, double step_s);

  MotionForces& forces();

 private:
  struct Work;
  std::unique_ptr<Work> work_;
};

}  // namespace palpate::dynamics

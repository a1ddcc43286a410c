// Time integrators of a moving body.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "core/dynamics/integrators/step_balance.h"
#include "core/dynamics/linear_algebra/linear_solver.h"
#include "core/dynamics/motion/motion_forces.h"

namespace palpate::dynamics {

/// One step of length h from (u, v) at time t; a = M^-1 f.
///
///   kExplicitEuler    u' = u + h v, v' = v + h a(u, v, t)                    (thesis eqs. 3.7, 3.8)
///   kSymplecticEuler  v' = v + h a(u, v, t), u' = u + h v'                   (thesis eqs. 4.4, 4.5)
///   kVelocityVerlet   u' = u + h v + h^2/2 a, a' = a(u', v + h a, t + h), v' = v + h/2 (a + a');
///                     a' is the next step's a (Groot and Warren 1997 with lambda = 1)
///   kRungeKutta4      the classical one
///   kImplicitEuler    (M + h D + h^2 K) dv = h (f(u, v, t + h) - h K v), u' = u + h v': one linearised step
///   of
///                     backward Euler (Baraff and Witkin 1998); each spring of K semidefinite
///   kPrefactored      backward Euler, (u' - u - h v) M / h^2 = f(u', (u' - u) / h, t + h), by iterations
///   with
///                     one matrix that is factored once (projective dynamics; prefactored_step.h)
///   kBackwardEuler    the same equation, solved by Newton's method (newton_step.h)
///   kBdf2             v' = (3 u' - 4 u + u_before) / 2h, a' = (3 v' - 4 v + v_before) / 2h, by Newton's
///   kTrapezoidal      u' = u + h/2 (v + v'), v' = v + h/2 (a + a'), by Newton's (Newmark's average
///   acceleration)
///   kXpbd             backward Euler's equation by sweeps over springs and domains (position_step.h)
///   kVbd              backward Euler's equation by sweeps over vertices (vertex_descent_step.h)
///
/// The order of convergence is 1, 1, 2, 4, 1, 1, 1, 2, 2, 1, 1: of the last two and of kPrefactored if each
/// step is solved. Held components follow their profiles.
enum class IntegratorKind {
  kExplicitEuler,
  kSymplecticEuler,
  kVelocityVerlet,
  kRungeKutta4,
  kImplicitEuler,
  kPrefactored,
  kBackwardEuler,
  kBdf2,
  kTrapezoidal,
  kXpbd,
  kVbd
};

/// All kinds, in order.
inline constexpr std::array<IntegratorKind, 11> kIntegrators{IntegratorKind::kExplicitEuler,
                                                             IntegratorKind::kSymplecticEuler,
                                                             IntegratorKind::kVelocityVerlet,
                                                             IntegratorKind::kRungeKutta4,
                                                             IntegratorKind::kImplicitEuler,
                                                             IntegratorKind::kPrefactored,
                                                             IntegratorKind::kBackwardEuler,
                                                             IntegratorKind::kBdf2,
                                                             IntegratorKind::kTrapezoidal,
                                                             IntegratorKind::kXpbd,
                                                             IntegratorKind::kVbd};

/// Whether it solves for the end of a step instead of computing it from the start: such a step has no bound.
bool is_implicit(IntegratorKind kind);

/// "explicit_euler", "symplectic_euler", "velocity_verlet", "runge_kutta_4", "implicit_euler", "prefactored",
/// "backward_euler", "bdf2", "trapezoidal", "xpbd" or "vbd". Throws: InputError.
IntegratorKind parse_integrator(std::string_view name);
/// The name that parse_integrator reads.
const char* integrator_name(IntegratorKind kind);

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

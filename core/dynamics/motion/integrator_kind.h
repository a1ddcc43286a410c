// The time integrators by name: who has to know of them and steps nothing needs no more than this.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

namespace palpate::dynamics {

/// One step of length h from (u, v) at time t; a = M^-1 f.
///
///   kExplicitEuler    u' = u + h v, v' = v + h a(u, v, t)                    (thesis eqs. 3.7, 3.8)
///   kSymplecticEuler  v' = v + h a(u, v, t), u' = u + h v'                   (thesis eqs. 4.4, 4.5)
///   kVelocityVerlet   u' = u + h v + h^2/2 a, a' = a(u', v + h a, t + h), v' = v + h/2 (a + a');
///                     a' is the next step's a (Groot and Warren 1997 with lambda = 1)
///   kRungeKutta4      the classical one
///   kImplicitEuler    (M + h D + h^2 K) dv = h (f(u, v, t + h) - h K v), u' = u + h v': one step of
///                     backward Euler, linearised (Baraff and Witkin 1998); each spring of K semidefinite
///   kPrefactored      backward Euler, (u' - u - h v) M / h^2 = f(u', (u' - u) / h, t + h), by iterations on
///                     one matrix that is factored once (projective dynamics; prefactored_step.h)
///   kBackwardEuler    the same equation, solved by Newton's method (newton_step.h)
///   kBdf2             v' = (3 u' - 4 u + u_before) / 2h, a' = (3 v' - 4 v + v_before) / 2h, by Newton's
///   kTrapezoidal      u' = u + h/2 (v + v'), v' = v + h/2 (a + a'), by Newton's method (average
///                     acceleration of Newmark)
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

/// How far a solver goes within a step, and when the step counts as solved.
struct StepSolverOptions {
  std::size_t iterations = 10;  ///< at most so many
  /// Forces out of balance over those of the inertial guess u + h v, at which a step is solved. 0: each step
  /// takes exactly `iterations`, counts as solved, and what they leave is measured now and then.
  double tolerance = 1e-10;
};

}  // namespace palpate::dynamics

// Time integrators of a moving body.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <string_view>
#include <vector>

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
///                     one matrix that is factored once: M / h^2 + gamma / h + Laplacian of k + c / h. For
///                     springs it is the local-global iteration of Liu, Bargteil, O'Brien and Kavan 2013.
///
/// The order of convergence is 1, 1, 2, 4, 1, 1. Held components follow their profiles.
enum class IntegratorKind {
  kExplicitEuler,
  kSymplecticEuler,
  kVelocityVerlet,
  kRungeKutta4,
  kImplicitEuler,
  kPrefactored
};

/// All kinds, in order.
inline constexpr std::array<IntegratorKind, 6> kIntegrators{
    IntegratorKind::kExplicitEuler, IntegratorKind::kSymplecticEuler, IntegratorKind::kVelocityVerlet,
    IntegratorKind::kRungeKutta4,   IntegratorKind::kImplicitEuler,   IntegratorKind::kPrefactored};

/// "explicit_euler", "symplectic_euler", "velocity_verlet", "runge_kutta_4", "implicit_euler" or
/// "prefactored". Throws: InputError.
IntegratorKind parse_integrator(std::string_view name);
/// The name that parse_integrator reads.
const char* integrator_name(IntegratorKind kind);

/// Which integrator, and how it solves where it has to.
struct IntegratorOptions {
  IntegratorKind kind = IntegratorKind::kSymplecticEuler;
  int threads = 1;
  double speed_limit_m_s =
      0.0;               ///< longer velocities are cut to this, but those of held vertices; 0: no limit
  LinearOptions linear;  ///< kImplicitEuler
  std::size_t iterations = 10;  ///< kPrefactored: at most so many a step
  double tolerance = 1e-10;     ///< kPrefactored: of the forces out of balance over the first ones
};

/// What happened in one step.
struct StepReport {
  std::size_t zero_length_springs = 0;  ///< over all force evaluations
  std::size_t speeds_cut = 0;           ///< vertices whose speed was cut to the limit
  std::size_t iterations = 0;           ///< of the linear or nonlinear solver
  bool solved = true;                   ///< whether the solver came to its tolerance
};

/// Steps one body. The result doesn't depend on the number of threads.
class Integrator {
 public:
  /// `model` must outlive this. Throws: as validate(MotionModel); InputError for a negative speed limit, and
  /// for kPrefactored with a model of more than springs.
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

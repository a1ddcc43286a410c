// The longest time step that stays stable: of one mode, in closed form; of a body at rest, from the extreme
// eigenvalues of its stiffness and damping; and a cheap bound from row sums. Derived in docs/stability.md.
#pragma once

#include <cstddef>
#include <span>

#include "core/base/types.h"
#include "core/dynamics/integrators/integrator.h"
#include "core/dynamics/linear_algebra/block_matrix.h"

namespace palpate::dynamics {

/// The bound on the step, in s, of one mode x'' = -omega^2 x - d x': every shorter step is stable.
///
///   kExplicitEuler    min(d / omega^2, 4 / (d + sqrt(d^2 - 4 omega^2)) if d >= 2 omega)
///   kSymplecticEuler  4 / (d + sqrt(d^2 + 4 omega^2)):   h^2 omega^2 + 2 h d < 4
///   kVelocityVerlet   2 / (d + sqrt(d^2 + omega^2)):     h^2 omega^2 + 4 h d < 4
///   kRungeKutta4      where |1 + z + z^2/2 + z^3/6 + z^4/24| = 1 first, z = h lambda,
///                     lambda^2 + d lambda + omega^2 = 0: 2.828 / omega undamped
///   the implicit ones have none (infinity)
///
/// Requires: omega and d finite and >= 0.
double stable_step_of_mode(IntegratorKind kind, double omega_per_s, double damping_per_s);

/// A bound on the step and where it comes from.
struct StableStep {
  double step_s = 0.0;                ///< infinity if there is no bound
  double step_at_most_s = 0.0;        ///< no longer step is stable; step_s itself where that is exact
  double stiffness_max_per_s2 = 0.0;  ///< largest eigenvalue of M^-1 K (row sums: a bound on it)
  double damping_max_per_s = 0.0;     ///< of M^-1 D
  Index limiting_vertex = kNoIndex;   ///< where the motion that sets the bound has the most kinetic energy
  std::size_t products = 0;           ///< with a matrix
  bool converged = true;              ///< whether all eigenvalues came to their tolerance
};

/// The predicted bound of a body at rest, to about 0.1%, for small motions about that state.
///
/// With K and D of the mass-scaled body symmetric, the step h is stable exactly if h^2 K + 2 h D < 4 for
/// symplectic Euler (4 h D for velocity Verlet): Lanczos finds the worst vector, whose mode gives the next h,
/// until h settles. For Runge-Kutta the eight fastest roots of lambda^2 + lambda D + K bind.
///
/// Explicit Euler is stable up to the least -2 Re(lambda) / |lambda|^2 over all roots. Up to 120 vertices all
/// are found, and the bound is exact. Beyond, step_s is the least quotient x* D x / x* K x (below every
/// root's, and exact where K and D share their vectors), and step_at_most_s the least of the eight fastest
/// roots' bounds and those of the vectors met on the way.
///
/// The thesis's volume force is not symmetric; the norm of its stiffness is added to that of K. Source:
/// Lanczos's method, and Spectra's restarted Arnoldi method. Throws: InputError where stiffness or damping
/// over mass, or their squares, leave the range of double precision.
StableStep predict_stable_step(const MotionModel& model, IntegratorKind kind, int threads = 1);

/// The same for a body that is given by its matrices, in N/m and N s/m, without held components.
/// Requires: both of one pattern; one mass above zero a row.
StableStep predict_stable_step(const BlockMatrix& stiffness, const BlockMatrix& damping,
                               std::span<const double> mass_kg, IntegratorKind kind, int threads = 1);

/// A step that is stable for certain, from row sums (Gershgorin): each row's sums of absolute values of M^-1
/// K and M^-1 D are taken as a mode. Never longer than the bound above. Throws: as that. Explicit Euler has
/// none (0): row sums don't bound the damping from below.
StableStep bound_stable_step(const MotionModel& model, IntegratorKind kind);

/// The predicted bound for small motions about the displacement `u`, with the stiffness and the springs'
/// directions there. Where that stiffness has negative eigenvalues the body leaves `u` with any step: the
/// bound is that of its other modes. Shape: one displacement a vertex.
StableStep predict_stable_step_at(const MotionModel& model, IntegratorKind kind, std::span<const Vec3> u,
                                  int threads = 1);

}  // namespace palpate::dynamics

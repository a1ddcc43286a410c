// The equations of a body of spheres: its stiffness, what holds it and what loads it; and its coefficients at
// rest.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/base/enum_names.h"
#include "core/dynamics/linear_algebra/block_matrix.h"
#include "core/mesh/boundary_problem.h"
#include "reference/finite_spheres/sphere_field.h"

namespace palpate::reference {

/// Matrix and right side.
///
/// Shape:  one block row, and one vector, a coefficient of the field.
struct SphereSystem {
  dynamics::BlockMatrix matrix;
  std::vector<Vec3> dead_n;   ///< gravity, body forces, tractions and forces on vertices
  std::vector<Vec3> moved_n;  ///< what supports and held faces that are moved pull with
  std::size_t points = 0;     ///< of the body, at which the stiffness was summed up
};

/// The stiffness of the body alone, in full, and its body forces.
///
///   K_ab = integral of lambda g_a g_b^T + mu (g_b g_a^T + (g_a . g_b) I),  f_a = integral of phi_a b,  g =
///   grad phi
///
/// kGauss: over the points of each tet. kNodal: one point a vertex L with the volume V_L of its median-dual
/// cell and
///   g_a(L) = 1 / V_L integral over the cell's surface of phi_a n,
/// one point a triangle of that surface, each shared by both cells beside it or by the boundary's own rule:
/// what the cells pass to each other cancels, and a linear field is in equilibrium with its tractions to
/// rounding. Source: J.-S. Chen, C.-T. Wu, S. Yoon and Y. You, Int. J. Numer. Meth. Engng 50 (2001), 435-466.
/// Its six strains a vertex cannot hold the twelve unknowns a vertex of kShepard: that stiffness is singular.
/// Body forces are integrated over four points a tet then, not at the vertices: a weight that is gathered at
/// the vertices of a coarse cell does not balance the averaged stress. Throws: InputError for a rule of
/// points that is not known, or a flat part of the mesh.
SphereSystem build_body_system(const SphereField& field, const BoundaryProblem& problem,
                               const IntegrationOptions& integration);

/// Adds what holds and loads the body: the functions are not one at their own vertex and zero at the others,
/// so all is integrated over the faces, with w the face's weight:
///
///   supports   K_ab += kappa w phi_a phi_b I,  f_a += kappa w phi_a by
///   tractions  f_a += w phi_a (t - p n)
///   held       by Nitsche's method, P the held axes, T_b the traction of function b (sigma n = T_b u_b):
///              K_ab += beta phi_a phi_b P - phi_a P T_b - phi_b T_a^T P,  f_a += (beta phi_a - T_a^T) P by,
///              beta = nitsche (lambda + 2 mu) / height of the tet over the face
///   forces     f_a += phi_a(vertex) F
///
/// Requires: a problem that problem_from_json accepts. Source of the third: J. Nitsche, Abh. Math. Sem. Univ.
/// Hamburg 36 (1971), 9-15.
void add_boundary(const SphereField& field, const BoundaryProblem& problem,
                  const IntegrationOptions& integration, double nitsche, SphereSystem& system);

/// What the boundary holds of the energy, and how well held faces are held.
struct BoundaryFigures {
  double quadratic_j = 0.0;      ///< of a^T K a / 2, what add_boundary added to the body
  double supports_j = 0.0;       ///< energy of the elastic supports
  double held_error_m = 0.0;     ///< largest |u - by| along held axes, at the points of held faces
  std::vector<Vec3> supports_n;  ///< force of each support on the body
};
BoundaryFigures measure_boundary(const SphereField& field, const BoundaryProblem& problem,
                                 const IntegrationOptions& integration, double nitsche,
                                 std::span<const Vec3> coefficients);

/// kAuto factors systems of few entries and iterates for others.
enum class SphereSolver { kAuto, kDirect, kConjugateGradients };

/// By the option `solver`.
inline constexpr EnumNames<SphereSolver, 3> kSphereSolverNames{"solver", {"auto", "direct", "cg"}};

/// How the system is solved.
struct SphereSolverOptions {
  SphereSolver solver = SphereSolver::kAuto;
  double tolerance = 1e-10;  ///< of the conjugate gradients: |f - K a| / |f|
  std::size_t most_iterations = 20000;
  int threads = 1;
};

/// What came of it.
struct SphereSolution {
  std::vector<Vec3> coefficients_m;
  bool converged = false;
  bool indefinite = false;  ///< a pivot, or a direction, without stiffness
  bool factored = false;
  std::size_t factor_entries = 0;  ///< 0 for the conjugate gradients
  std::size_t iterations = 0;      ///< of the conjugate gradients, or corrections after the factorisation
  double residual_relative = 0.0;  ///< |f - K a| / |f|, computed anew
};

/// Solves K a = f by a sparse Cholesky factorisation (Eigen, with one correction), or by conjugate gradients
/// with incomplete Cholesky factors by blocks.
SphereSolution solve_spheres(const SphereSystem& system, const SphereSolverOptions& options);

}  // namespace palpate::reference

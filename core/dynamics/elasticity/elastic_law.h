// Elastic energies of a deformation gradient, with exact stress and tangent.
#pragma once

#include <array>
#include <string_view>

#include "core/dynamics/linear_algebra/matrix3.h"

namespace palpate::dynamics {

/// How a deformation gradient becomes an energy. All agree to second order in the strain.
///
///   kLinear      mu eps : eps + lambda/2 (tr eps)^2,            eps = sym(F) - I
///   kCorotated   mu |S - I|^2 + lambda/2 (tr S - 3)^2,          F = R S (polar decomposition)
///   kNeoHookean  mu/2 (I1 - 3) - mu ln J + lambda/2 (ln J)^2,   I1 = F : F, J = det F
///   kStableNeoHookean  mu/2 (I1 - 3) - mu (J - 1) + (lambda + mu)/2 (J - 1)^2
///
/// All but kLinear don't change when F is rotated from the left: a rigid motion gives no force. The last has
/// a finite energy for every F, turned inside out or flat: up to a constant it is mu/2 |F|^2 + (lambda +
/// mu)/2 (J - 1 - mu / (lambda + mu))^2.
///
/// Source of kStableNeoHookean: B. Smith, F. de Goes and T. Kim, ACM Trans. Graph. 37 (2018), without their
/// barrier; as two constraints: M. Macklin and M. Mueller, MIG 2021.
enum class StrainLaw { kLinear, kCorotated, kNeoHookean, kStableNeoHookean };

/// "linear", "corotated", "neo_hookean" or "stable_neo_hookean". Throws: InputError.
StrainLaw parse_strain_law(std::string_view name);
/// The name that parse_strain_law reads.
const char* strain_law_name(StrainLaw law);

/// Lame's moduli of one energy, in Pa; either may be zero, or negative where another energy makes up for it.
struct Moduli {
  double lambda_pa = 0.0;
  double mu_pa = 0.0;
};

/// Second derivative of an energy by F: entry (3 i + j, 3 k + l) is d2W / dF_ij dF_kl, in Pa. Symmetric.
using Tangent9 = std::array<double, 81>;

/// The rotation nearest to f: R of the polar decomposition where det f > 0, and the proper rotation of the
/// singular vectors elsewhere. Accurate to rounding.
Mat3 nearest_rotation(const Mat3& f);

/// Energy a unit of volume, in J/m^3, of the gradient I + h; `h` is the displacement gradient, so that small
/// strains lose no digits. Infinite for kNeoHookean where det(I + h) <= 0.
double energy_density(StrainLaw law, const Moduli& moduli, const Mat3& h);

/// First Piola-Kirchhoff stress dW/dF, in Pa. Requires: a finite energy.
Mat3 stress(StrainLaw law, const Moduli& moduli, const Mat3& h);

/// Stress of damping, in Pa, of the strain rate that belongs to the energy; `viscous` has Pa s, `rate` is
/// dF/dt. With d the rate below, the dissipation is mu d : d + lambda/2 (tr d)^2 and this its derivative by
/// dF/dt:
///
///   kLinear      d = sym(dF/dt), the rate of eps;                      P = 2 mu d + lambda tr d I
///   kCorotated   d = dU/dt, F = Q U with U positive (Q a rotation, or a mirrored one where det F < 0);
///                P = Q (T - [y]x), T = 2 mu d + lambda tr d I, (tr U I - U) y = axial of T U
///   kNeoHookean  d = sym(dF/dt F^-1), whose trace is d(ln J)/dt;       P = (2 mu d + lambda tr d I) F^-T
///   kStableNeoHookean  d = sym(F^T dF/dt), the rate of Green's strain; P = F (2 mu d + lambda tr d I)
///
/// All but the first don't change when a spin W F is added to dF/dt, and P F^T is symmetric: a rotation is
/// not resisted, and no moment is exerted. P : dF/dt >= 0 where no modulus is negative. At F = I all are the
/// first.
/// Requires: a finite energy.
/// Source:   kCorotated: dU/dt as A. Hoger and D. Carlson, Quart. Appl. Math. 42 (1984), have it.
Mat3 damping_stress(StrainLaw law, const Moduli& viscous, const Mat3& h, const Mat3& rate);

/// The matrix of damping_stress, which is linear in `rate`. Symmetric.
Tangent9 damping_tangent(StrainLaw law, const Moduli& viscous, const Mat3& h);

/// dP/dF. Requires: a finite energy.
Tangent9 tangent(StrainLaw law, const Moduli& moduli, const Mat3& h);

/// The nearest positive semidefinite matrix: negative eigenvalues become zero.
Tangent9 project_to_semidefinite(const Tangent9& tangent);

}  // namespace palpate::dynamics

// What one vertex of a domain feels of the domain's tangent: a 3 x 3 block, in closed form.
#pragma once

#include "core/dynamics/elasticity/elastic_law.h"

namespace palpate::dynamics {

/// B_ik = sum over j, l of dP_ij/dF_kl g_j g_l of the tangent of elastic_law.h at I + h, with `gradient` g of
/// the vertex's shape function in 1/m; in Pa/m^2. Where a factor of it would be negative it is taken as zero,
/// so that B is semidefinite:
///
///   kLinear      mu |g|^2 I + (mu + lambda) g g^T
///   kCorotated   2 mu |g|^2 I + lambda (R g)(R g)^T - (2 mu - lambda tr E) R [g]x^T (tr S I - S)^-1 [g]x R^T
///   kNeoHookean  mu |g|^2 I + (mu + lambda - lambda ln J) w w^T,   w = F^-T g
///
/// Requires: a finite energy.
Mat3 vertex_stiffness(StrainLaw law, const Moduli& moduli, const Mat3& h, const Vec3& gradient);

/// The same of a damping stress that is taken at the end of a step from `before` to `h`, times the step's
/// length, so that with `viscous` in Pa s it is in Pa s/m^2. With T the stress of the law's own rate:
///
///   kLinear, kCorotated  vertex_stiffness of the viscous moduli
///   kNeoHookean          mu |w|^2 I + (mu + lambda) w w^T,   w = F^-T g
///   kStableNeoHookean    F (mu |g|^2 I + (mu + lambda) g g^T) F^T + max(g . T g, 0) I
///
/// The last two grow with F^-1 and with F squared: a stiffness times b / h falls short of them. Of what turns
/// with F within the step only the last summand is in; what is left out is less than half of what is in where
/// the body is being stretched, and takes away where it comes back.
/// Requires: a finite energy.
Mat3 vertex_damping(StrainLaw law, const Moduli& viscous, const Mat3& h, const Mat3& before,
                    const Vec3& gradient);

}  // namespace palpate::dynamics

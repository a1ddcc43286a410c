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

}  // namespace palpate::dynamics

// What is left of a displacement when the body may be put back by a rigid motion: its deformation.
#pragma once

#include <span>
#include <vector>

#include "core/base/types.h"

namespace palpate::judge {

/// The field less its best small rigid motion t + omega x (p - c): the one that leaves least of sum w |u|^2.
///
///   c = sum w p / sum w,   t = sum w u / sum w,   J omega = sum w (p - c) x u,   J = sum w (|q|^2 I - q q^T)
///
/// with q = p - c. It is linear in the field and a projection, orthogonal in that norm: what is taken off an
/// error and off the reference separately is what is taken off both fields. Where all weight lies on a line
/// or a point, the rotations that move none of it are left out; without any weight the field stays as it is.
///
/// Shape:  one point in m, one weight >= 0 and one displacement a row; one displacement a row comes back.
/// Throws: ContractError for other sizes.
std::vector<Vec3> without_rigid_motion(std::span<const Vec3> points, std::span<const double> weight,
                                       std::span<const Vec3> field);

}  // namespace palpate::judge

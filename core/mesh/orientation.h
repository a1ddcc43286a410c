// The exact orientation of four points.
#pragma once

#include "core/base/types.h"

namespace palpate {

/// Sign of (b - a) x (c - a) . (d - a), exact: +1 positively oriented, -1 negatively, 0 coplanar.
///
/// A floating-point filter answers the clear cases, expansions of doubles the rest. Exact while no product of
/// three coordinates (scaled by the largest) underflows: coordinate ratios inside 2^-300 .. 2^300.
/// Requires: finite coordinates; compiled without fast-math.
/// Source:   Shewchuk, "Adaptive precision floating-point arithmetic", Discrete Comput. Geom. 18 (1997).
int orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

}  // namespace palpate

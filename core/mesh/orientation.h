// The exact orientation of four points.
#pragma once

#include <cmath>

#include "core/base/types.h"

namespace palpate {

/// The exact sign by expansions of doubles, without a filter: what orientation() falls back on.
int orientation_by_expansions(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

/// Sign of (b - a) x (c - a) . (d - a), exact: +1 positively oriented, -1 negatively, 0 coplanar.
///
/// A floating-point filter answers the clear cases, expansions of doubles the rest. Exact while no product of
/// three coordinates (scaled by the largest) underflows: coordinate ratios inside 2^-300 .. 2^300.
/// Requires: finite coordinates; compiled without fast-math.
/// Source:   Shewchuk, "Adaptive precision floating-point arithmetic", Discrete Comput. Geom. 18 (1997).
inline int orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const Vec3 u = b - a;
  const Vec3 v = c - a;
  const Vec3 w = d - a;
  const double yz = u.y * v.z;
  const double zy = u.z * v.y;
  const double zx = u.z * v.x;
  const double xz = u.x * v.z;
  const double xy = u.x * v.y;
  const double yx = u.y * v.x;
  const double det = (yz - zy) * w.x + (zx - xz) * w.y + (xy - yx) * w.z;
  const double permanent = (std::fabs(yz) + std::fabs(zy)) * std::fabs(w.x) +
                           (std::fabs(zx) + std::fabs(xz)) * std::fabs(w.y) +
                           (std::fabs(xy) + std::fabs(yx)) * std::fabs(w.z);
  // Shewchuk's bound (7 + 56 eps) eps with eps = 2^-53, rounded up; below the floor products may have
  // underflowed.
  const double bound = 7.8e-16 * permanent;
  if (std::isfinite(permanent) && permanent > 1e-270) {
    if (det > bound) return 1;
    if (det < -bound) return -1;
  }
  return orientation_by_expansions(a, b, c, d);
}

}  // namespace palpate

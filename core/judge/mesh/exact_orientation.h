// The judge's own orientation predicate, independent of the one that the judged use.
#pragma once

#include "core/base/types.h"

namespace palpate::judge {

/// Sign of (b - a) x (c - a) . (d - a), exact: +1 positively oriented, -1 negatively, 0 coplanar.
///
/// A floating-point filter with a proven error bound answers the clear cases; whole numbers of any size, got
/// by shifting the twelve coordinates to a common exponent, answer the rest. Right for all finite doubles,
/// subnormal and huge ones too (docs/exact_orientation.md has the proof).
/// Requires: finite coordinates; compiled without fast-math.
int exact_orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

/// The same sign, always by whole numbers: slow, for tests and for what the filter leaves.
int integer_orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

}  // namespace palpate::judge

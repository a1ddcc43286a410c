// Cuts at the planes between the cells of a grid; lengths are counted in cells.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "core/base/component.h"

namespace palpate::springs {

/// Where the edge from a to b meets the plane x[axis] = plane. Requires: ends on both sides of it.
inline Vec3 meet_plane(const Vec3& a, const Vec3& b, std::size_t axis, double plane) {
  const double from = component(a, axis);
  const double t = (plane - from) / (component(b, axis) - from);
  return a + t * (b - a);
}

/// The cells along an axis, first to last, that points reach into.
struct CellSpan {
  long first = 0;
  long last = 0;
};

/// The cells that the hull of `points` reaches into; one that is flat lies in the cell above it.
inline CellSpan span_cells(std::span<const Vec3> points, std::size_t axis) {
  double least = component(points.front(), axis);
  double most = least;
  for (const Vec3& point : points) {
    least = std::min(least, component(point, axis));
    most = std::max(most, component(point, axis));
  }
  const auto first = static_cast<long>(std::floor(least));
  return {first, std::max(first, static_cast<long>(std::ceil(most)) - 1)};
}

/// Cuts parts at each plane between the cells of a span, lowest first. `cut(part, plane, below, above)` cuts
/// one of them; `take(cell, parts)` is given what lies in each cell but the last, and `parts` keeps what lies
/// there.
template <typename Part, typename Cut, typename Take>
void cut_between_cells(const CellSpan& span, const Cut& cut, const Take& take, std::vector<Part>& parts) {
  for (long cell = span.first; cell < span.last; ++cell) {
    std::vector<Part> below;
    std::vector<Part> above;
    for (const Part& part : parts) cut(part, static_cast<double>(cell + 1), below, above);
    take(cell, below);
    parts.swap(above);
  }
}

}  // namespace palpate::springs

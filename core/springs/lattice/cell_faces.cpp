#include "core/springs/lattice/cell_faces.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/base/component.h"

namespace palpate::springs {
namespace {

using Part = std::array<Vec3, 3>;

/// Cuts a triangle at a plane.
void cut_part(const Part& part, std::size_t axis, double plane, std::vector<Part>& below,
              std::vector<Part>& above) {
  const auto is_low = [&](std::size_t i) { return component(part[i], axis) <= plane; };
  const std::size_t lows = (is_low(0) ? 1U : 0U) + (is_low(1) ? 1U : 0U) + (is_low(2) ? 1U : 0U);
  if (lows == 0 || lows == 3) {
    (lows == 0 ? above : below).push_back(part);
    return;
  }
  std::size_t tip = 0;  // the corner that is alone on its side
  while (is_low(tip) != (lows == 1)) ++tip;
  const Vec3& a = part[tip];
  const Vec3& b = part[(tip + 1) % 3];
  const Vec3& c = part[(tip + 2) % 3];
  const auto meet = [&](const Vec3& to) {
    const double from = component(a, axis);
    return a + ((plane - from) / (component(to, axis) - from)) * (to - a);
  };
  const Vec3 ab = meet(b);
  const Vec3 ac = meet(c);
  std::vector<Part>& own = lows == 1 ? below : above;
  std::vector<Part>& other = lows == 1 ? above : below;
  own.push_back({a, ab, ac});
  other.push_back({ab, b, c});
  other.push_back({ab, c, ac});
}

}  // namespace

std::vector<std::array<Vec3, 3>> split_at_cells(const std::array<Vec3, 3>& corners) {
  std::vector<Part> parts{corners};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double least = component(corners[0], axis);
    double most = least;
    for (const Vec3& corner : corners) {
      least = std::min(least, component(corner, axis));
      most = std::max(most, component(corner, axis));
    }
    std::vector<Part> done;
    const auto last = static_cast<long>(std::ceil(most));
    for (auto plane = static_cast<long>(std::floor(least)) + 1; plane < last; ++plane) {
      std::vector<Part> rest;
      for (const Part& part : parts) cut_part(part, axis, static_cast<double>(plane), done, rest);
      parts.swap(rest);
    }
    parts.insert(parts.end(), done.begin(), done.end());
  }
  std::erase_if(parts, [](const Part& p) { return length_sq(cross(p[1] - p[0], p[2] - p[0])) == 0.0; });
  return parts;
}

}  // namespace palpate::springs

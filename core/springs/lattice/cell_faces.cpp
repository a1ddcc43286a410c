#include "core/springs/lattice/cell_faces.h"

#include <algorithm>
#include <cstddef>

#include "core/base/component.h"
#include "core/springs/lattice/cell_cuts.h"

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
  const Vec3 ab = meet_plane(a, b, axis, plane);
  const Vec3 ac = meet_plane(a, c, axis, plane);
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
    std::vector<Part> done;
    const auto cut = [&](const Part& part, double plane, std::vector<Part>& below, std::vector<Part>& above) {
      cut_part(part, axis, plane, below, above);
    };
    const auto take = [&](long /*cell*/, const std::vector<Part>& below) {
      done.insert(done.end(), below.begin(), below.end());
    };
    cut_between_cells(span_cells(corners, axis), cut, take, parts);
    parts.insert(parts.end(), done.begin(), done.end());
  }
  std::erase_if(parts, [](const Part& p) { return length_sq(cross(p[1] - p[0], p[2] - p[0])) == 0.0; });
  return parts;
}

}  // namespace palpate::springs

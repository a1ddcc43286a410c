// Which tets the sizing field lets grow in a pass.
#pragma once

#include <array>
#include <limits>

#include "core/mesh/geometry.h"
#include "core/simplify/fusion.h"
#include "core/simplify/sizing.h"

namespace palpate::simplify {

/// Is tet t smaller than its place allows: volume < r^3 largest_far, with r the relative size at its
/// barycenter? Always for an infinite `largest_far`.
inline bool may_grow(const SizingField& sizing, double largest_far, const FusionMesh& mesh, Index t) {
  if (largest_far == std::numeric_limits<double>::infinity()) return true;
  const Tet& tet = mesh.tets[t];
  const std::array<Vec3, 4> p{mesh.points[tet[0]], mesh.points[tet[1]], mesh.points[tet[2]],
                              mesh.points[tet[3]]};
  const double volume = signed_volume(p[0], p[1], p[2], p[3]);
  const auto bound = [&](double size) { return size * size * size * largest_far; };
  if (volume >= largest_far) return false;
  if (volume < bound(sizing.near_size())) return true;
  return volume < bound(sizing.relative_size(0.25 * (p[0] + p[1] + p[2] + p[3])));
}

/// One flag a tet, in storage order: has it one of these vertices (one flag each, by the input's numbers)?
inline std::vector<std::uint8_t> find_tets_with_vertex(const FusionMesh& mesh,
                                                       const std::vector<std::uint8_t>& is_chosen) {
  std::vector<std::uint8_t> found(mesh.tets.size(), 0);
  for (Index t = 0; t < mesh.tets.size(); ++t) {
    for (const Index v : mesh.tets[t]) found[t] |= is_chosen[mesh.origin_of_vertex(v)];
  }
  return found;
}

}  // namespace palpate::simplify

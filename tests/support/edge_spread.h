// How evenly long the edges of a mesh's skin are.
#pragma once

#include <cmath>
#include <cstddef>

#include "core/judge/surface/surface.h"
#include "core/mesh/geometry.h"
#include "core/mesh/tet_mesh.h"

namespace palpate::testing_support {

/// The standard deviation of length / wanted length over the edges of a skin, over their mean. `wanted_at`
/// gives the wanted length at the middle of an edge, or what it is to be a multiple of.
template <typename WantedAt>
double spread_of_edges(const TetMesh& mesh, const WantedAt& wanted_at) {
  const SurfaceMesh skin = judge::build_boundary(mesh);
  double count = 0.0;
  double sum = 0.0;
  double squares = 0.0;
  for (const Triangle& t : skin.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3& a = skin.points[t[k]];
      const Vec3& b = skin.points[t[(k + 1) % 3]];
      const double ratio = length(b - a) / wanted_at(0.5 * (a + b));
      count += 1.0;
      sum += ratio;
      squares += ratio * ratio;
    }
  }
  return std::sqrt(count * squares / (sum * sum) - 1.0);
}

}  // namespace palpate::testing_support

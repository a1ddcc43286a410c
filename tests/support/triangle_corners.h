// The corners of one triangle of a surface.
#pragma once

#include <array>
#include <cstddef>

#include "core/mesh/tet_mesh.h"

namespace palpate::testing_support {

inline std::array<Vec3, 3> triangle_corners(const SurfaceMesh& surface, std::size_t i) {
  const Triangle& t = surface.triangles[i];
  return {surface.points[t[0]], surface.points[t[1]], surface.points[t[2]]};
}

}  // namespace palpate::testing_support

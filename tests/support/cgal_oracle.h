// CGAL's exact geometry as an oracle: a translation unit of its own, because its headers are heavy.
#pragma once

#include <cstdint>

#include "core/base/types.h"
#include "core/mesh/tet_mesh.h"

namespace palpate::test {

/// The sign of (b - a) x (c - a) . (d - a) by CGAL's exact predicates.
int cgal_orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

/// The same sign in rational arithmetic (GMP): slow, and free of filters and of bounds on the exponents.
int rational_orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

/// Do two triangles of the surface meet elsewhere than in a shared vertex or edge?
bool is_self_intersecting(const SurfaceMesh& surface);

/// The number of pairs of triangles that do so. The triangles must make a manifold, with or without rims.
std::uint64_t count_self_intersections(const SurfaceMesh& surface);

}  // namespace palpate::test

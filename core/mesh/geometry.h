// Lengths, volumes and normal forms of tet meshes and surfaces, in the mesh's own length unit.
#pragma once

#include <span>

#include "core/mesh/tet_mesh.h"

namespace palpate {

/// Signed volume of tet (a, b, c, d): (b - a) x (c - a) . (d - a) / 6. Rounded; use orientation() for the
/// sign.
constexpr double signed_volume(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  return dot(cross(b - a, c - a), d - a) / 6.0;
}

/// Sum of the signed volumes of the tets.
double total_volume(const TetMesh& mesh);

/// Volume enclosed by a closed surface, from the divergence theorem. Negative if it is inside out.
double enclosed_volume(const SurfaceMesh& surface);

/// Corners of the axis-parallel bounding box; both zero for no points.
struct BoundingBox {
  Vec3 low;
  Vec3 high;
};
/// The box of the points.
BoundingBox bounding_box(std::span<const Vec3> points);

/// The longest of the box's three sides.
double longest_side(const BoundingBox& box);

/// The number of the point nearest to `place`; of equally near ones the first. Linear time.
/// Throws: ContractError if there are no points.
Index nearest_point(std::span<const Vec3> points, const Vec3& place);

/// Moves and scales the points uniformly so that the bounding box is centred on the origin and its longest
/// side is [-1, 1] (thesis 4.2.2). Returns the factor that lengths were multiplied by.
/// Throws: InputError if all points coincide.
double normalize_to_unit_box(std::span<Vec3> points);

}  // namespace palpate

#include "core/mesh/geometry.h"

#include <algorithm>

#include "core/base/error.h"

namespace palpate {

double total_volume(const TetMesh& mesh) {
  double sum = 0.0;
  for (const Tet& t : mesh.tets) {
    sum += signed_volume(mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]], mesh.points[t[3]]);
  }
  return sum;
}

double enclosed_volume(const SurfaceMesh& surface) {
  if (surface.points.empty()) return 0.0;
  const Vec3 origin = surface.points.front();
  double sum = 0.0;
  for (const Triangle& t : surface.triangles) {
    sum += signed_volume(origin, surface.points[t[0]], surface.points[t[1]], surface.points[t[2]]);
  }
  return sum;
}

BoundingBox bounding_box(std::span<const Vec3> points) {
  if (points.empty()) return {};
  BoundingBox box{points.front(), points.front()};
  for (const Vec3& p : points) {
    box.low = {std::min(box.low.x, p.x), std::min(box.low.y, p.y), std::min(box.low.z, p.z)};
    box.high = {std::max(box.high.x, p.x), std::max(box.high.y, p.y), std::max(box.high.z, p.z)};
  }
  return box;
}

double normalize_to_unit_box(std::span<Vec3> points) {
  const BoundingBox box = bounding_box(points);
  const Vec3 size = box.high - box.low;
  const double longest = std::max({size.x, size.y, size.z});
  if (!(longest > 0.0)) throw InputError("the mesh", 0, "points that differ", "all points in one place");
  const double scale = 2.0 / longest;
  const Vec3 center = 0.5 * (box.low + box.high);
  for (Vec3& p : points) p = scale * (p - center);
  return scale;
}

}  // namespace palpate

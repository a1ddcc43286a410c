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

double longest_side(const BoundingBox& box) {
  const Vec3 size = box.high - box.low;
  return std::max({size.x, size.y, size.z});
}

Index nearest_point(std::span<const Vec3> points, const Vec3& place) {
  require(!points.empty(), "nearest_point: no points");
  const auto nearer = [&](const Vec3& a, const Vec3& b) {
    return length_sq(a - place) < length_sq(b - place);
  };
  return static_cast<Index>(std::min_element(points.begin(), points.end(), nearer) - points.begin());
}

double normalize_to_unit_box(std::span<Vec3> points) {
  const BoundingBox box = bounding_box(points);
  const double longest = longest_side(box);
  if (!(longest > 0.0)) throw InputError("the mesh", 0, "points that differ", "all points in one place");
  const double scale = 2.0 / longest;
  const Vec3 center = 0.5 * (box.low + box.high);
  for (Vec3& p : points) p = scale * (p - center);
  return scale;
}

}  // namespace palpate

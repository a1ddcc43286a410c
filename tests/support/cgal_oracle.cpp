#include "tests/support/cgal_oracle.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Surface_mesh.h>
#include <gmpxx.h>

#include <vector>

namespace palpate::test {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;

Point to_point(const Vec3& p) {
  return {p.x, p.y, p.z};
}

using Mesh = CGAL::Surface_mesh<Point>;

Mesh to_mesh(const SurfaceMesh& surface) {
  Mesh mesh;
  std::vector<Mesh::Vertex_index> vertices;
  for (const Vec3& p : surface.points) vertices.push_back(mesh.add_vertex(to_point(p)));
  for (const Triangle& t : surface.triangles) mesh.add_face(vertices[t[0]], vertices[t[1]], vertices[t[2]]);
  return mesh;
}

}  // namespace

int cgal_orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  return static_cast<int>(CGAL::orientation(to_point(a), to_point(b), to_point(c), to_point(d)));
}

int rational_orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  struct Exact {
    mpq_class x, y, z;
  };
  const auto minus = [](const Vec3& p, const Vec3& q) {
    return Exact{mpq_class(p.x) - mpq_class(q.x), mpq_class(p.y) - mpq_class(q.y),
                 mpq_class(p.z) - mpq_class(q.z)};
  };
  const Exact u = minus(b, a);
  const Exact v = minus(c, a);
  const Exact w = minus(d, a);
  const mpq_class det =
      (u.y * v.z - u.z * v.y) * w.x + (u.z * v.x - u.x * v.z) * w.y + (u.x * v.y - u.y * v.x) * w.z;
  return sgn(det);
}

bool is_self_intersecting(const SurfaceMesh& surface) {
  return CGAL::Polygon_mesh_processing::does_self_intersect(to_mesh(surface));
}

std::uint64_t count_self_intersections(const SurfaceMesh& surface) {
  std::vector<std::pair<Mesh::Face_index, Mesh::Face_index>> pairs;
  CGAL::Polygon_mesh_processing::self_intersections(to_mesh(surface), std::back_inserter(pairs));
  return pairs.size();
}

}  // namespace palpate::test

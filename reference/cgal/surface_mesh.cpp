// Built with CGAL, GPL: this program is distributed under GPL-3.0-or-later.
#include <CGAL/Polygon_mesh_processing/orientation.h>
#include <CGAL/Polygon_mesh_processing/remesh.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>

#include <cmath>
#include <iterator>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/mesh/geometry.h"
#include "reference/cgal/surface_cgal.h"
#include "reference/cgal/surface_tools.h"

namespace palpate::reference {
namespace pmp = CGAL::Polygon_mesh_processing;
using Kernel = SurfaceKernel;
using Mesh = CgalSurface;
using Face = Mesh::Face_index;
using Vertex = Mesh::Vertex_index;

Mesh to_cgal(const SurfaceMesh& surface) {
  Mesh mesh;
  for (const Vec3& p : surface.points) mesh.add_vertex(Kernel::Point_3(p.x, p.y, p.z));
  for (const Triangle& t : surface.triangles) {
    const Face face = mesh.add_face(Vertex(t[0]), Vertex(t[1]), Vertex(t[2]));
    require(face != Mesh::null_face(), "to_cgal: the surface is not manifold");
  }
  return mesh;
}

Vec3 point_of(const Mesh& mesh, Vertex vertex) {
  const Kernel::Point_3& p = mesh.point(vertex);
  return {p.x(), p.y(), p.z()};
}

SurfaceMesh from_cgal(const Mesh& mesh) {
  SurfaceMesh surface;
  for (const Vertex v : mesh.vertices()) surface.points.push_back(point_of(mesh, v));
  for (const Face f : mesh.faces()) {
    Triangle triangle{};
    std::size_t k = 0;
    for (const Vertex v : mesh.vertices_around_face(mesh.halfedge(f))) {
      triangle[k++] = static_cast<Index>(static_cast<std::size_t>(v));
    }
    surface.triangles.push_back(triangle);
  }
  return surface;
}

Vec3 normal_of(const Mesh& mesh, Face face) {
  const auto h = mesh.halfedge(face);
  const Vec3 a = point_of(mesh, mesh.source(h));
  const Vec3 b = point_of(mesh, mesh.target(h));
  const Vec3 c = point_of(mesh, mesh.target(mesh.next(h)));
  return cross(b - a, c - a);
}

namespace {

/// Neighbours that nearly lie on each other (normals more than 150 degrees apart): a flipped patch.
bool has_folded_edge(const Mesh& mesh) {
  constexpr double kFoldCosine = -0.866;
  for (const auto edge : mesh.edges()) {
    const auto h = mesh.halfedge(edge);
    const Vec3 a = normal_of(mesh, mesh.face(h));
    const Vec3 b = normal_of(mesh, mesh.face(mesh.opposite(h)));
    if (dot(a, b) <= kFoldCosine * length(a) * length(b)) return true;
  }
  return false;
}

bool is_sound(const Mesh& mesh) {
  return CGAL::is_closed(mesh) && !has_folded_edge(mesh) && !pmp::does_self_intersect(mesh);
}

/// Twice the volume over the surface: of a thin wall the distance between its sides.
double mean_thickness(const SurfaceMesh& surface) {
  double area = 0.0;
  for (const Triangle& t : surface.triangles) {
    const Vec3& p = surface.points[t[0]];
    area += 0.5 * length(cross(surface.points[t[1]] - p, surface.points[t[2]] - p));
  }
  return 2.0 * enclosed_volume(surface) / area;
}

}  // namespace

Intersections find_self_intersections(const SurfaceMesh& surface) {
  const Mesh mesh = to_cgal(surface);
  std::vector<std::pair<Face, Face>> pairs;
  pmp::self_intersections(mesh, std::back_inserter(pairs));
  Intersections result{pairs.size(), {}};
  if (!pairs.empty()) {
    const Triangle& a =
        surface.triangles[static_cast<std::size_t>(std::min(pairs[0].first, pairs[0].second))];
    result.place = (1.0 / 3.0) * (surface.points[a[0]] + surface.points[a[1]] + surface.points[a[2]]);
  }
  return result;
}

bool is_nested_well(const SurfaceMesh& surface) {
  return pmp::does_bound_a_volume(to_cgal(surface));
}

RemeshedSurface remesh_surface(const SurfaceMesh& surface, double edge_length) {
  if (!(edge_length > 0.0) || !std::isfinite(edge_length)) {
    throw InputError("edge_length", 0, "a positive length", "another number");
  }
  constexpr double kShorten = 0.9;
  constexpr int kLengths = 8;  // down to 0.48 of the wanted length
  double length = edge_length;
  for (int i = 0; i < kLengths; ++i, length *= kShorten) {
    for (const unsigned sweeps : {10U, 15U}) {
      Mesh mesh = to_cgal(surface);
      pmp::isotropic_remeshing(mesh.faces(), length, mesh,
                               pmp::parameters::number_of_iterations(sweeps).number_of_relaxation_steps(3));
      mesh.collect_garbage();
      if (mesh.number_of_faces() > 3 && is_sound(mesh)) return {from_cgal(mesh), length};
    }
  }
  throw InputError(
      "skin", 0, "a body with room for edges of " + short_number(edge_length),
      "one that is " + short_number(mean_thickness(surface)) +
          " thick on average (twice its volume over its surface), where such edges, and those of "
          "half the length, fold or cut each other. palpate mesh without --vertices keeps the "
          "skin as it is (with --repair, mended), and palpate scene takes that mesh");
}

}  // namespace palpate::reference

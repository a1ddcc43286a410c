// Built with CGAL, GPL: this program is distributed under GPL-3.0-or-later.
#include "reference/cgal_collapse/collapse.h"

#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Bounded_normal_change_placement.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Count_stop_predicate.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/GarlandHeckbert_plane_policies.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>
#include <CGAL/assertions_behaviour.h>
#include <CGAL/exceptions.h>

#include <stdexcept>
#include <string>

#include "core/base/error.h"

namespace palpate::reference {
namespace {

namespace sms = CGAL::Surface_mesh_simplification;
using Kernel = CGAL::Simple_cartesian<double>;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;

Mesh to_cgal(const SurfaceMesh& surface) {
  Mesh mesh;
  for (const Vec3& p : surface.points) mesh.add_vertex(Kernel::Point_3(p.x, p.y, p.z));
  for (const Triangle& t : surface.triangles) {
    const auto face =
        mesh.add_face(Mesh::Vertex_index(t[0]), Mesh::Vertex_index(t[1]), Mesh::Vertex_index(t[2]));
    if (face == Mesh::null_face()) throw InputError("skin", 0, "a manifold boundary", "one that is not");
  }
  return mesh;
}

SurfaceMesh from_cgal(const Mesh& mesh) {
  SurfaceMesh surface;
  for (const auto v : mesh.vertices()) {
    const Kernel::Point_3& p = mesh.point(v);
    surface.points.push_back({p.x(), p.y(), p.z()});
  }
  for (const auto f : mesh.faces()) {
    Triangle triangle{};
    std::size_t k = 0;
    for (const auto v : mesh.vertices_around_face(mesh.halfedge(f))) {
      triangle[k++] = static_cast<Index>(static_cast<std::size_t>(v));
    }
    surface.triangles.push_back(triangle);
  }
  return surface;
}

void collapse_garland_heckbert(Mesh& mesh, const sms::Count_stop_predicate<Mesh>& stop) {
  using Policies = sms::GarlandHeckbert_plane_policies<Mesh, Kernel>;
  const Policies policies(mesh);
  const sms::Bounded_normal_change_placement<Policies::Get_placement> placement(policies.get_placement());
  sms::edge_collapse(mesh, stop, CGAL::parameters::get_cost(policies.get_cost()).get_placement(placement));
}

}  // namespace

SurfaceMesh collapse_edges(const SurfaceMesh& surface, const CollapseSettings& settings) {
  CGAL::set_error_behaviour(CGAL::THROW_EXCEPTION);
  try {
    Mesh mesh = to_cgal(surface);
    const sms::Count_stop_predicate<Mesh> stop(settings.edges);
    if (settings.cost == CollapseCost::kLindstromTurk) {
      sms::edge_collapse(mesh, stop);
    } else {
      collapse_garland_heckbert(mesh, stop);
    }
    mesh.collect_garbage();
    return from_cgal(mesh);
  } catch (const CGAL::Failure_exception& error) {
    throw std::runtime_error("CGAL: " + error.expression() + " does not hold (" + error.filename() + ":" +
                             std::to_string(error.line_number()) + ")");
  }
}

}  // namespace palpate::reference

// Built with CGAL, GPL: this program is distributed under GPL-3.0-or-later.
#include "reference/cgal_mesh/mesh.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Mesh_complex_3_in_triangulation_3.h>
#include <CGAL/Mesh_criteria_3.h>
#include <CGAL/Mesh_triangulation_3.h>
#include <CGAL/Polyhedral_mesh_domain_with_features_3.h>
#include <CGAL/Random.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/assertions_behaviour.h>
#include <CGAL/exceptions.h>
#include <CGAL/make_mesh_3.h>

#include <stdexcept>
#include <string>
#include <unordered_map>

#include "core/base/error.h"

namespace palpate::reference {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Skin = CGAL::Surface_mesh<Kernel::Point_3>;
using Domain = CGAL::Polyhedral_mesh_domain_with_features_3<Kernel, Skin>;
using Triangulation = CGAL::Mesh_triangulation_3<Domain>::type;
using Complex =
    CGAL::Mesh_complex_3_in_triangulation_3<Triangulation, Domain::Corner_index, Domain::Curve_index>;
using Criteria = CGAL::Mesh_criteria_3<Triangulation>;
namespace parameters = CGAL::parameters;

constexpr unsigned kSeed = 1;
constexpr double kFacetAngleDeg = 25.0;   ///< least angle of a face, that of CGAL's examples
constexpr double kRadiusEdgeRatio = 2.0;  ///< greatest circumradius over the shortest edge

Skin to_cgal(const SurfaceMesh& surface) {
  Skin skin;
  for (const Vec3& p : surface.points) skin.add_vertex(Kernel::Point_3(p.x, p.y, p.z));
  for (const Triangle& t : surface.triangles) {
    const auto face =
        skin.add_face(Skin::Vertex_index(t[0]), Skin::Vertex_index(t[1]), Skin::Vertex_index(t[2]));
    if (face == Skin::null_face()) throw InputError("skin", 0, "a manifold boundary", "one that is not");
  }
  return skin;
}

TetMesh from_cgal(const Complex& complex) {
  TetMesh mesh;
  std::unordered_map<Triangulation::Vertex_handle, Index> index_of;
  for (auto cell = complex.cells_in_complex_begin(); cell != complex.cells_in_complex_end(); ++cell) {
    Tet tet{};
    for (int k = 0; k < 4; ++k) {
      const auto [entry, is_new] = index_of.emplace(cell->vertex(k), static_cast<Index>(mesh.points.size()));
      if (is_new) {
        const auto& p = cell->vertex(k)->point();
        mesh.points.push_back({p.x(), p.y(), p.z()});
      }
      tet[static_cast<std::size_t>(k)] = entry->second;
    }
    mesh.tets.push_back(tet);
  }
  return mesh;
}

Complex refine(const Domain& domain, const DelaunaySettings& settings) {
  const Criteria criteria(parameters::edge_size = settings.size, parameters::facet_angle = kFacetAngleDeg,
                          parameters::facet_size = settings.size,
                          parameters::facet_distance = settings.facet_distance * settings.size,
                          parameters::cell_radius_edge_ratio = kRadiusEdgeRatio,
                          parameters::cell_size = settings.size);
  Complex complex = CGAL::make_mesh_3<Complex>(domain, criteria, parameters::no_perturb(),
                                               parameters::no_exude(), parameters::manifold());
  if (settings.perturb) CGAL::perturb_mesh_3(complex, domain, parameters::time_limit = 0.0);
  if (settings.exude) CGAL::exude_mesh_3(complex, parameters::time_limit = 0.0);
  return complex;
}

}  // namespace

TetMesh mesh_inside(const SurfaceMesh& skin, const DelaunaySettings& settings) {
  CGAL::set_error_behaviour(CGAL::THROW_EXCEPTION);
  try {
    CGAL::get_default_random() = CGAL::Random(kSeed);
    CGAL::Random random(kSeed);
    const Skin given = to_cgal(skin);
    Domain domain(given, &random);
    if (settings.feature_deg > 0.0) domain.detect_features(settings.feature_deg);
    TetMesh mesh = from_cgal(refine(domain, settings));
    if (mesh.tets.empty()) throw std::runtime_error("CGAL left no tetrahedra");
    return mesh;
  } catch (const CGAL::Failure_exception& error) {
    throw std::runtime_error("CGAL: " + error.expression() + " does not hold (" + error.filename() + ":" +
                             std::to_string(error.line_number()) + ")");
  }
}

}  // namespace palpate::reference

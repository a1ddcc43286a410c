// Built with CGAL, GPL: this program is distributed under GPL-3.0-or-later.
#include "reference/cgal/remesh.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Mesh_3/tet_soup_to_c3t3.h>
#include <CGAL/Tetrahedral_remeshing/Remeshing_triangulation_3.h>
#include <CGAL/assertions_behaviour.h>
#include <CGAL/exceptions.h>
#include <CGAL/tetrahedral_remeshing.h>

#include <array>
#include <map>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <vector>

namespace palpate::reference {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Triangulation = CGAL::Tetrahedral_remeshing::Remeshing_triangulation_3<Kernel>;
using PatchIndex = Triangulation::Cell::Surface_patch_index;

constexpr int kDomain = 1;

void build_triangulation(const TetMesh& mesh, Triangulation& triangulation) {
  std::vector<Kernel::Point_3> points;
  points.reserve(mesh.points.size());
  for (const Vec3& p : mesh.points) points.emplace_back(p.x, p.y, p.z);
  std::vector<std::array<int, 5>> cells;
  cells.reserve(mesh.tets.size());
  for (const Tet& t : mesh.tets) {
    cells.push_back({static_cast<int>(t[0]), static_cast<int>(t[1]), static_cast<int>(t[2]),
                     static_cast<int>(t[3]), kDomain});
  }
  const std::map<std::array<int, 3>, PatchIndex> no_patches;
  std::vector<Triangulation::Vertex_handle> handles;
  const bool built =
      CGAL::build_triangulation<Triangulation, true>(triangulation, points, cells, no_patches, handles);
  if (!built) throw std::runtime_error("CGAL cannot build a triangulation from the mesh: it is not manifold");
}

TetMesh take_domain(const Triangulation& triangulation) {
  TetMesh mesh;
  std::unordered_map<Triangulation::Vertex_handle, Index> index_of;
  for (const auto cell : triangulation.finite_cell_handles()) {
    if (cell->subdomain_index() == 0) continue;
    for (int i = 0; i < 4; ++i) index_of.emplace(cell->vertex(i), kNoIndex);
  }
  for (const auto vertex : triangulation.finite_vertex_handles()) {
    const auto entry = index_of.find(vertex);
    if (entry == index_of.end()) continue;
    entry->second = static_cast<Index>(mesh.points.size());
    mesh.points.push_back({vertex->point().x(), vertex->point().y(), vertex->point().z()});
  }
  for (const auto cell : triangulation.finite_cell_handles()) {
    if (cell->subdomain_index() == 0) continue;
    Tet tet{};
    for (int i = 0; i < 4; ++i) tet[static_cast<std::size_t>(i)] = index_of.at(cell->vertex(i));
    mesh.tets.push_back(tet);
  }
  return mesh;
}

}  // namespace

TetMesh remesh(const TetMesh& mesh, const RemeshSettings& settings) {
  CGAL::set_error_behaviour(CGAL::THROW_EXCEPTION);
  try {
    Triangulation triangulation;
    build_triangulation(mesh, triangulation);
    CGAL::tetrahedral_isotropic_remeshing(triangulation, settings.edge_length,
                                          CGAL::parameters::number_of_iterations(settings.iterations)
                                              .remesh_boundaries(settings.remesh_boundary));
    TetMesh result = take_domain(triangulation);
    if (result.tets.empty()) throw std::runtime_error("CGAL left no tetrahedra");
    return result;
  } catch (const CGAL::Failure_exception& error) {
    throw std::runtime_error("CGAL: " + error.expression() + " does not hold (" + error.filename() + ":" +
                             std::to_string(error.line_number()) + ")");
  }
}

}  // namespace palpate::reference

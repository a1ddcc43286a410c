// Built with gmsh, GPL: this program is distributed under GPL-3.0-or-later.
#include <gmsh.h>

#include <algorithm>
#include <stdexcept>
#include <string>
#include <unordered_map>

#include "core/base/error.h"
#include "core/mesh/geometry.h"
#include "core/mesh/orientation.h"
#include "core/mesh/topology.h"
#include "reference/gmsh/gmsh_tools.h"

namespace palpate::reference {
namespace {

/// The triangles of each connected piece of a surface, in the order of their first triangle.
std::vector<std::vector<Triangle>> split_pieces(const SurfaceMesh& surface) {
  std::vector<Index> root(surface.points.size());
  for (Index v = 0; v < root.size(); ++v) root[v] = v;
  const auto find = [&](Index v) {
    while (root[v] != v) v = root[v] = root[root[v]];
    return v;
  };
  for (const Triangle& t : surface.triangles) {
    root[find(t[1])] = find(t[0]);
    root[find(t[2])] = find(t[0]);
  }
  std::vector<std::vector<Triangle>> pieces;
  std::unordered_map<Index, std::size_t> number;
  for (const Triangle& t : surface.triangles) {
    const auto [entry, is_new] = number.emplace(find(t[0]), pieces.size());
    if (is_new) pieces.emplace_back();
    pieces[entry->second].push_back(t);
  }
  return pieces;
}

/// Is it one piece with cavities, which are turned inward? Then gmsh has to be told what is a hole.
bool is_hollow(const SurfaceMesh& surface, const std::vector<std::vector<Triangle>>& pieces) {
  std::size_t outer = 0;
  for (const auto& piece : pieces) {
    if (enclosed_volume({surface.points, piece}) > 0.0) ++outer;
  }
  return pieces.size() > 1 && outer == 1;
}

/// Hands the surface to gmsh: as one discrete patch, or, if it has cavities, one for each skin, that of the
/// outside first. Node tag = vertex + 1.
void add_discrete_surface(const SurfaceMesh& surface) {
  std::vector<std::vector<Triangle>> pieces = split_pieces(surface);
  const bool hollow = is_hollow(surface, pieces);
  if (!hollow) pieces = {surface.triangles};
  gmsh::option::setNumber("Mesh.Renumber", hollow ? 0 : 1);  // else patch by patch
  std::stable_sort(pieces.begin(), pieces.end(), [&](const auto& a, const auto& b) {
    return enclosed_volume({surface.points, a}) > enclosed_volume({surface.points, b});
  });
  std::vector<int> loops;
  for (const std::vector<Triangle>& piece : pieces) {
    std::vector<std::size_t> corners;
    std::vector<std::size_t> tags;
    for (const Triangle& t : piece) {
      for (const Index v : t) corners.push_back(std::size_t{v} + 1);
    }
    tags = corners;
    std::sort(tags.begin(), tags.end());
    tags.erase(std::unique(tags.begin(), tags.end()), tags.end());
    std::vector<double> coordinates;
    for (const std::size_t tag : tags) {
      const Vec3& p = surface.points[tag - 1];
      coordinates.insert(coordinates.end(), {p.x, p.y, p.z});
    }
    const int patch = gmsh::model::addDiscreteEntity(2);
    gmsh::model::mesh::addNodes(2, patch, tags, coordinates);
    gmsh::model::mesh::addElementsByType(patch, kTriangleType, {}, corners);
    loops.push_back(gmsh::model::geo::addSurfaceLoop({patch}));
  }
  gmsh::model::geo::addVolume(loops);
  gmsh::model::geo::synchronize();
}

TetMesh collect_tets() {
  std::vector<std::size_t> tags;
  std::vector<double> coordinates;
  std::vector<double> parameters;
  gmsh::model::mesh::getNodes(tags, coordinates, parameters);
  std::vector<std::size_t> order(tags.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return tags[a] < tags[b]; });
  TetMesh mesh;
  std::unordered_map<std::size_t, Index> index_of;
  for (const std::size_t i : order) {
    index_of[tags[i]] = static_cast<Index>(mesh.points.size());
    mesh.points.push_back({coordinates[3 * i], coordinates[3 * i + 1], coordinates[3 * i + 2]});
  }
  std::vector<std::size_t> element_tags;
  std::vector<std::size_t> corners;
  gmsh::model::mesh::getElementsByType(kTetType, element_tags, corners);
  for (std::size_t i = 0; i + 3 < corners.size(); i += 4) {
    Tet tet{};
    for (std::size_t k = 0; k < 4; ++k) tet[k] = index_of.at(corners[i + k]);
    mesh.tets.push_back(tet);
  }
  if (mesh.tets.empty()) throw std::runtime_error("gmsh left no tetrahedra: it could not fill the surface");
  return mesh;
}

std::vector<Triangle> sorted_corners(std::vector<Triangle> triangles) {
  for (Triangle& t : triangles) std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

}  // namespace

TetMesh fill_surface(const SurfaceMesh& surface, const FillSettings& settings) {
  const double interior_size = settings.interior_size;
  if (!(interior_size > 0.0)) throw InputError("interior_size", 0, "a positive length", "another number");
  gmsh::model::add("fill");
  add_discrete_surface(surface);
  gmsh::option::setNumber("Mesh.Algorithm3D", 1);
  gmsh::option::setNumber("Mesh.CharacteristicLengthExtendFromBoundary", 0);
  gmsh::option::setNumber("Mesh.CharacteristicLengthMin", interior_size);
  gmsh::option::setNumber("Mesh.CharacteristicLengthMax", interior_size);
  gmsh::option::setNumber("Mesh.OptimizeThreshold", settings.optimize_threshold);
  gmsh::logger::start();
  std::string failure;
  try {
    gmsh::model::mesh::generate(3);
  } catch (...) {  // 4.8 throws integers, strings or exceptions; the log says what went wrong
    failure = "generate() threw";
  }
  std::vector<std::string> log;
  gmsh::logger::get(log);
  gmsh::logger::stop();
  for (const std::string& line : log) {
    if (line.rfind("Error", 0) == 0) failure = line;
  }
  if (!failure.empty()) throw std::runtime_error("gmsh could not fill the surface: " + failure);
  return collect_tets();
}

void check_filled(const SurfaceMesh& surface, TetMesh& mesh) {
  if (mesh.points.size() < surface.points.size())
    throw std::runtime_error("gmsh dropped vertices of the skin");
  if (!std::equal(surface.points.begin(), surface.points.end(), mesh.points.begin())) {
    throw std::runtime_error("gmsh moved vertices of the skin");
  }
  const auto& p = mesh.points;
  for (Tet& t : mesh.tets) {
    if (orientation(p[t[0]], p[t[1]], p[t[2]], p[t[3]]) < 0) std::swap(t[2], t[3]);
    if (orientation(p[t[0]], p[t[1]], p[t[2]], p[t[3]]) == 0) {
      throw std::runtime_error("gmsh left a tetrahedron without volume");
    }
  }
  if (sorted_corners(build_boundary(mesh)) != sorted_corners(surface.triangles)) {
    throw std::runtime_error("gmsh changed the triangles of the skin");
  }
}

}  // namespace palpate::reference

// Two tools on gmsh: filling a closed surface with tets, and reading .msh files.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/mesh/tet_mesh.h"

namespace palpate::reference {

/// Starts gmsh quietly with one thread, and stops it.
class GmshSession {
 public:
  GmshSession();
  ~GmshSession();
  GmshSession(const GmshSession&) = delete;
  GmshSession& operator=(const GmshSession&) = delete;
};

/// Fills a closed surface by Delaunay refinement (algorithm 1), interior edges about `interior_size` long.
///
/// The skin stays: vertices [0, surface.points.size()) of the result are the surface's, in its order, and its
/// boundary triangles are the surface's. Throws: std::runtime_error if gmsh fails, leaves no tets, or changed
/// the skin.
TetMesh fill_surface(const SurfaceMesh& surface, double interior_size);

/// Reads a .msh file of linear tetrahedra (points, lines and triangles are left out, and noted).
/// Throws: InputError naming any other element kind, or a file that gmsh cannot read.
TetMesh read_msh(const std::filesystem::path& path, std::vector<std::string>& notes);

}  // namespace palpate::reference

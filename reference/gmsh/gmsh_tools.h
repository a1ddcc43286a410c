// Two tools on gmsh: filling a closed surface with tets, and reading .msh files.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
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

struct FillSettings {
  double interior_size = 0.0;  ///< edges inside are about as long
  /// gmsh's Mesh.OptimizeThreshold, with gmsh's default: it optimises the tets whose quality, by its own
  /// measure, is below.
  double optimize_threshold = 0.3;
};

/// Takes "optimize_threshold" out of `options`; gmsh's default if it is absent.
/// Throws: InputError unless it is a number from 0 to 1.
double take_optimize_threshold(nlohmann::json& options);

/// Fills a closed surface by Delaunay refinement (algorithm 1).
///
/// The skin stays: vertices [0, surface.points.size()) of the result are the surface's, in its order, and its
/// boundary triangles are the surface's. Throws: std::runtime_error if gmsh fails, leaves no tets, or changed
/// the skin.
TetMesh fill_surface(const SurfaceMesh& surface, const FillSettings& settings);

/// Reads a .msh file of linear tetrahedra (points, lines and triangles are left out, and noted).
/// Throws: InputError naming any other element kind, or a file that gmsh cannot read.
TetMesh read_msh(const std::filesystem::path& path, std::vector<std::string>& notes);

}  // namespace palpate::reference

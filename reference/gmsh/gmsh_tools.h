// Two tools on gmsh: filling a closed surface with tets, and reading .msh files.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/mesh/tet_mesh.h"

namespace palpate::reference {

// gmsh's numbers of kinds of elements.
inline constexpr int kTriangleType = 2;
inline constexpr int kTetType = 4;

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

/// Fills a closed surface by Delaunay refinement (algorithm 1). This is what is timed: what came out is
/// looked at by check_filled, outside the clock. Throws: std::runtime_error if gmsh fails or leaves no tets.
TetMesh fill_surface(const SurfaceMesh& surface, const FillSettings& settings);

/// Orients the tets and makes sure that the skin stayed: vertices [0, surface.points.size()) of the mesh are
/// the surface's, in its order, and its boundary triangles are the surface's. Throws: std::runtime_error if
/// gmsh changed the skin or left a tet without volume.
void check_filled(const SurfaceMesh& surface, TetMesh& mesh);

/// Reads a .msh file of linear tetrahedra (points, lines and triangles are left out, and noted). `scratch` is
/// a folder that somebody else removes: of files that gmsh crashes on, something is left in it. Throws:
/// InputError naming any other element kind, or a file that gmsh cannot read.
TetMesh read_msh(const std::filesystem::path& path, const std::filesystem::path& scratch,
                 std::vector<std::string>& notes);

}  // namespace palpate::reference

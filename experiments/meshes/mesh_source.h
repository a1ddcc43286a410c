// Where a plan's or a command's mesh comes from: a shape that is made, a surface that is filled, a file.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/mesh/io/medit.h"
#include "core/mesh/tet_mesh.h"
#include "experiments/meshes/shape_request.h"

namespace palpate::experiments {

/// One line of `palpate list meshes`.
struct ShapeInfo {
  std::string name;
  std::string summary;
  std::string unit;         ///< "mm" for bodies, "cm" for the bean, "1" for built shapes
  std::string unavailable;  ///< why it cannot be made here, empty if it can
};

std::vector<ShapeInfo> list_shapes();

/// What a made mesh is kept under, beside what make_cached adds: the request, and for a body the hash of
/// the data that it is made from. Throws: UnavailableError if there are none.
std::string shape_key(const ShapeRequest& request);

/// Which part of the request the shape of that name cannot take, as a sentence; empty if it can take all.
/// A seed moves the skin's vertices along the skin (jitter_skin), so flat-sided shapes take none but the
/// cube. Sizes are not looked at.
std::string shape_complaint(const ShapeRequest& request);

/// Makes a shape; the same request gives the same mesh to the byte. Finished meshes are kept in a cache below
/// the build folder, keyed by the request and the programs that made them. Throws: InputError for an unknown
/// name (with the nearest), an impossible size or what shape_complaint() refuses; UnavailableError if a
/// program,
///         a package or the organ data is missing, or a mesher fails or hangs.
MadeMesh make_shape(const ShapeRequest& request);

/// A surface that becomes a mesh.
struct SurfaceRequest {
  std::filesystem::path file;
  MeshSize size{};                 ///< nothing: the skin as it is, edges inside as long as its mean
  bool repair = false;             ///< mend what is open, turned or intersects itself
  std::optional<double> unit_m{};  ///< where it is given: no body is filled that cannot be so large or small
};

/// Is it the name of a surface (.stl, .off, .obj, .ply)?
bool is_surface_file(const std::filesystem::path& path);

/// Is it the name of a mesh that read_mesh reads (.mesh, .msh, .vtk, .vtu)?
bool is_mesh_file(const std::filesystem::path& path);

/// Fills a closed surface (.stl, .off, .obj, .ply) with tets. The skin is kept, unless a vertex count leaves
/// so few for the inside that its edges would be 1.1 times as long as the skin's: then it is remeshed, with
/// edges 2.25 times as long as inside. What a repair changed is a note. Throws: InputError for an open,
/// non-manifold, self-intersecting or inside-out surface, saying where, also where a repair could not mend
/// it;
///         UnavailableError as above.
MadeMesh mesh_surface(const SurfaceRequest& request);

/// The same, kept in the cache of made meshes by the file's hash and the request.
MadeMesh mesh_surface_cached(const SurfaceRequest& request);

/// Reads .mesh itself, and .msh, .vtk, .vtu through the converter programs.
/// Throws: InputError for a broken file, and for tets that all stand alone (doubled_points_complaint()).
MeditFile read_mesh(const std::filesystem::path& path,
                    ReadOrientation orientation = ReadOrientation::kRestore);

/// Writes .mesh itself, and .vtu through the converter. Throws: InputError for any other ending.
void write_mesh(const std::filesystem::path& path, const TetMesh& mesh);

}  // namespace palpate::experiments

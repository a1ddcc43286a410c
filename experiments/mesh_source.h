// Where a plan's or a command's mesh comes from: a shape that is made, a surface that is filled, a file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/mesh/medit.h"
#include "core/mesh/tet_mesh.h"

namespace palpate::experiments {

/// How fine a made mesh is to be; at most one of the two. Without either, a shape takes its own default.
struct MeshSize {
  std::optional<std::uint64_t> vertices{};
  std::optional<double> edge_length{};  ///< of the interior, in the shape's own unit
};

/// A shape by name, as in `palpate make` and in plans.
struct ShapeRequest {
  std::string name;
  MeshSize size{};
  std::uint64_t seed = 0;          ///< used by the shapes that have random parts
  std::optional<double> jitter{};  ///< cube only: largest move of an inner vertex, in cells
};

/// One line of `palpate list meshes`.
struct ShapeInfo {
  std::string name;
  std::string summary;
  std::string unit;         ///< "mm" for the real organs, "1" for built shapes
  std::string unavailable;  ///< why it cannot be made here, empty if it can
};

/// A mesh and one line for each thing worth saying about how it came about.
struct MadeMesh {
  TetMesh mesh;
  std::vector<std::string> notes;
};

std::vector<ShapeInfo> list_shapes();

/// What a made mesh is kept under, beside what make_cached adds: the request, and for an organ the hash of
/// its image. Throws: UnavailableError if there is no image.
std::string shape_key(const ShapeRequest& request);

/// Makes a shape; the same request gives the same mesh to the byte. Finished meshes are kept in a cache below
/// the build folder, keyed by the request and the programs that made them. Throws: InputError for an unknown
/// name (with the nearest) or an impossible size; UnavailableError if a program,
///         a package or the organ data is missing, or a mesher fails or hangs.
MadeMesh make_shape(const ShapeRequest& request);

/// Fills a closed surface (.stl, .off, .obj, .ply) with tets; the skin is kept unless a vertex count needs
/// another. Throws: InputError for an open, non-manifold, self-intersecting or inside-out surface, saying
/// where;
///         UnavailableError as above.
MadeMesh mesh_surface(const std::filesystem::path& surface, const MeshSize& size);

/// Reads .mesh itself, and .msh, .vtk, .vtu through the converter programs.
MeditFile read_mesh(const std::filesystem::path& path,
                    ReadOrientation orientation = ReadOrientation::kRestore);

/// Writes .mesh itself, and .vtu through the converter. Throws: InputError for any other ending.
void write_mesh(const std::filesystem::path& path, const TetMesh& mesh);

}  // namespace palpate::experiments

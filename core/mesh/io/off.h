// OFF surface files: how surfaces travel between the programs.
#pragma once

#include <filesystem>

#include "core/mesh/tet_mesh.h"

namespace palpate {

/// Reads an ASCII OFF file of triangles. Memory is proportional to what the file holds, never to its counts.
/// Throws: InputError for a missing or truncated file, other polygons, an index out of range or a coordinate
///         that is not finite.
SurfaceMesh read_off(const std::filesystem::path& path);

/// Writes an ASCII OFF file, doubles in their shortest form that reads back to the same bits; whole or not at
/// all. Throws: InputError if the folder cannot be written or the disk is full.
void write_off(const std::filesystem::path& path, const SurfaceMesh& surface);

}  // namespace palpate

// A displaced mesh as a file for ParaView.
#pragma once

#include <filesystem>
#include <span>

#include "core/mesh/tet_mesh.h"

namespace palpate {

/// Writes an ASCII VTK unstructured grid (.vtu): the rest shape's points in m, its tets, and the displacement
/// of each vertex as point data "displacement_m" (ParaView's Warp By Vector shows the deformed shape). Shape:
/// one displacement a vertex. Throws: InputError if the file cannot be written.
void write_displacement_vtu(const std::filesystem::path& path, const TetMesh& mesh,
                            std::span<const Vec3> displacement_m);

}  // namespace palpate

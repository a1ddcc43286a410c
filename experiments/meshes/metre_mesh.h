// Meshes of the command line in metres.
#pragma once

#include <string>

#include "core/mesh/tet_mesh.h"

namespace palpate::experiments {

/// The mesh of a file, oriented, judged, and with its points times `unit_m`. Notes go to standard error, also
/// where it is longer than any organ. Throws: InputError for a file that cannot be read, a mesh that the
/// judge finds invalid or a unit in which it has no size of a body.
TetMesh read_mesh_in_metres(const std::string& path, double unit_m);

}  // namespace palpate::experiments

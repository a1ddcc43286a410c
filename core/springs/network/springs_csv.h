// Spring constants as a file: vertex_a,vertex_b,rest_length_m,stiffness_n_per_m.
#pragma once

#include <filesystem>

#include "core/mesh/spring_network.h"
#include "core/mesh/tet_mesh.h"

namespace palpate::springs {

/// Writes a header and one row a spring: vertices counted from 0, a < b, sorted; numbers read back to the
/// same bits. The file is whole or absent. Throws: InputError if it cannot be written.
void write_springs_csv(const std::filesystem::path& path, const SpringNetwork& network);

/// Reads it back and holds it against the mesh that it is for: every edge of the mesh has one row, other rows
/// join the apexes of an interior face (face_opposite), rest lengths are those of the mesh to 1 part in 10^6,
/// stiffness is finite and at least 0.
///
/// Requires: `mesh` has its points in metres.
/// Throws: InputError with file and line: unreadable, another header, a row that is not two whole numbers and
///         two finite numbers, a >= b, not sorted, a vertex or a pair that the mesh has not, a rest length of
///         another mesh or unit, a negative stiffness, an edge without a row.
SpringNetwork read_springs_csv(const std::filesystem::path& path, const TetMesh& mesh);

}  // namespace palpate::springs

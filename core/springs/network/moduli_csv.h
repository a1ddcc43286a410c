// Trained dilatation moduli as a file: vertex,modulus_pa or tet,modulus_pa.
#pragma once

#include <filesystem>
#include <vector>

#include "core/mesh/tet_mesh.h"

namespace palpate::springs {

/// Moduli m of the energy 1/2 m V (tr eps)^2, of node-averaged dilatation (one a vertex) or of the tets.
struct DilatationModuli {
  bool at_vertices = true;
  std::vector<double> modulus_pa;
};

/// Writes a header and one row a vertex or tet, counted from 0; numbers read back to the same bits. The file
/// is whole or absent. Throws: InputError if it cannot be written.
void write_moduli_csv(const std::filesystem::path& path, const DilatationModuli& moduli);

/// Reads it back for the mesh that it is for.
/// Throws: InputError with file and line: unreadable, another header, a row that is not a number counted up
///         and a finite modulus of at least 0, more or fewer rows than the mesh has vertices or tets.
DilatationModuli read_moduli_csv(const std::filesystem::path& path, const TetMesh& mesh);

}  // namespace palpate::springs

// MEDIT .mesh (ASCII), the project's own mesh format (thesis 4.1).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/mesh/tet_mesh.h"

namespace palpate {

/// What to do with tets that are negatively oriented.
enum class ReadOrientation {
  kRestore,  ///< swap two vertices, and say so in the notes
  kKeep      ///< as in the file (the judge reads so)
};

/// A mesh as read, with one line for each thing that the reader changed or left out.
struct MeditFile {
  TetMesh mesh;
  std::vector<std::string> notes;
  std::size_t isolated_vertices = 0;  ///< left out: the mesh's vertices are numbered without them
};

/// Reads an ASCII .mesh file: Vertices, Triangles (read and checked, not kept: the boundary follows from the
/// tets) and Tetrahedra, 1-based indices. Corners, ridges and other markers that carry no element are
/// skipped.
///
/// Memory: proportional to the elements found in the file, never to a count that the file claims.
/// Throws: InputError with file and line for a missing, empty, truncated or binary file, counts that
/// disagree,
///         an index of 0 or out of range, NaN or infinite coordinates, a tet or triangle with a repeated
///         vertex, other element kinds (named), and no tetrahedra at all.
MeditFile read_medit(const std::filesystem::path& path,
                     ReadOrientation orientation = ReadOrientation::kRestore);

/// Writes vertices, boundary triangles and tets; doubles in their shortest form that reads back to the same
/// bits. The same mesh gives the same bytes. Written beside `path` and renamed: a failure leaves no half
/// file. A broken mesh (non-manifold, inverted) is written too, so that the judge can look at it.
/// Throws: InputError if the folder cannot be written or the disk is full; ContractError if a coordinate is
///         not finite or a tet names a vertex that does not exist.
void write_medit(const std::filesystem::path& path, const TetMesh& mesh);

}  // namespace palpate

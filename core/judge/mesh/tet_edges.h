// Edges of a mesh and which of them each tet has, by the judge's own reckoning.
#pragma once

#include <array>
#include <vector>

#include "core/mesh/tet_mesh.h"

namespace palpate::judge {

/// Shape:  edges holds each edge once, a < b, sorted; of_tet has one entry a tet, edge numbers in the order
///         of kTetEdges.
struct TetEdges {
  std::vector<Edge> edges;
  std::vector<std::array<Index, 6>> of_tet;
};

/// Numbers the edges. Linear time: one bucket a smaller vertex.
/// Throws: ContractError if an index is not below mesh.points.size().
TetEdges number_edges(const TetMesh& mesh);

}  // namespace palpate::judge

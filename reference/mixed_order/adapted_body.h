// An organ on a mesh that is coarser inside and finer where something holds or loads it.
#pragma once

#include <cstddef>
#include <vector>

#include "core/mesh/boundary_problem.h"
#include "core/mesh/tet_mesh.h"

namespace palpate::reference {

/// How far, and where.
struct AdaptOptions {
  double ratio = 0.7;        ///< of the tets that palpate.refined removes; the skin stays to the bit. 0: none
  std::size_t vertices = 0;  ///< edges are halved until there are so many,
  std::size_t added = 0;     ///< and until so many are added; both 0: none is
  double near_size = 0.5;    ///< wanted length of edges at touched faces, over that far away
  double reach = 0.15;       ///< where the far length begins: a distance, in diagonals of the bounding box
};

/// A body, and what of its mesh is new.
struct AdaptedBody {
  TetMesh mesh;
  BoundaryProblem problem;
  std::size_t vertices_coarse = 0;  ///< before edges were halved
};

/// Coarsens the inside (simplify_refined), then halves edges (bisect_edges), sized by the distance d to the
/// faces that are held, supported or loaded: near_size + (1 - near_size) (3 t^2 - 2 t^3), t = min(1, d /
/// reach). Faces keep their places, so regions, loads and supports are the same to rounding.
///
/// Throws: InputError for a force on a vertex inside the body, which may be gone, and for fields that vary
///         (body_force_n_m3, held_field_m).
AdaptedBody adapt_body(const TetMesh& mesh, const BoundaryProblem& problem, const AdaptOptions& options);

}  // namespace palpate::reference

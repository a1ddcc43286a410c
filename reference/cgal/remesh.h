// CGAL's tetrahedral isotropic remeshing on plain arrays.
#pragma once

#include "core/mesh/tet_mesh.h"

namespace palpate::reference {

struct RemeshSettings {
  double edge_length = 0.0;
  unsigned iterations = 1;       ///< CGAL's own default
  bool remesh_boundary = false;  ///< CGAL's remesh_boundaries; true is its own default
};

/// Builds CGAL's triangulation from the mesh (its loader's, which closes the boundary with infinite cells),
/// remeshes it, and takes the tets of the domain out again, without the vertices that none of them uses.
///
/// Tets keep CGAL's vertex order, which is positive where the tet is: an inverted one stays visible. No
/// feature edges are given, so with `remesh_boundary` CGAL takes the whole boundary for one smooth patch.
/// Throws: std::runtime_error if CGAL fails, with what it says in one line.
TetMesh remesh(const TetMesh& mesh, const RemeshSettings& settings);

}  // namespace palpate::reference

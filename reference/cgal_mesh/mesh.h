// CGAL's Mesh_3: a body filled anew by Delaunay refinement, skin and inside.
#pragma once

#include "core/mesh/tet_mesh.h"

namespace palpate::reference {

/// What the refinement aims at, and what comes after it.
struct DelaunaySettings {
  double size = 0.0;            ///< greatest circumradius of a tet and of a face's ball, in the mesh's unit
  double facet_distance = 0.1;  ///< how far a face may be from the skin, over `size`
  double feature_deg = 0.0;     ///< sharper edges of the skin are kept as such; 0: none are
  bool perturb = true;          ///< sliver perturbation
  bool exude = true;            ///< sliver exudation
};

/// Meshes the inside of a closed surface. Seeds are fixed, no step has a time limit.
/// Throws: InputError if the surface is not manifold; std::runtime_error if CGAL fails, with what it says in
/// one line, or leaves nothing.
TetMesh mesh_inside(const SurfaceMesh& skin, const DelaunaySettings& settings);

}  // namespace palpate::reference

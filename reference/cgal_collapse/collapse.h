// CGAL's edge collapse of a closed triangle surface.
#pragma once

#include <cstddef>

#include "core/mesh/tet_mesh.h"

namespace palpate::reference {

/// What a collapse costs, and where its vertex goes.
enum class CollapseCost {
  kLindstromTurk,   ///< CGAL's own default: volume and boundary preserving, without memory
  kGarlandHeckbert  ///< plane quadrics, with the bound on normals of CGAL's own example
};

struct CollapseSettings {
  CollapseCost cost = CollapseCost::kLindstromTurk;
  std::size_t edges = 0;  ///< collapses until fewer edges than that are left, or none can be collapsed
};

/// Collapses edges of a closed manifold surface, cheapest first.
/// Throws: InputError if the surface is not manifold; std::runtime_error if CGAL fails, with what it says in
/// one
///         line.
SurfaceMesh collapse_edges(const SurfaceMesh& surface, const CollapseSettings& settings);

}  // namespace palpate::reference

// Collapses of boundary edges under the guard of a GuardedBoundary.
#pragma once

#include <cstdint>
#include <limits>

#include "core/simplify/skin_guard/guarded_boundary.h"
#include "core/simplify/tet_operations/score_rule.h"
#include "core/simplify/tet_operations/working_mesh.h"

namespace palpate::simplify {

/// When a collapse is refused, and when enough are made.
struct SurfaceCollapseOptions {
  double least_score = 0.0;       ///< a collapse may leave no tet below this ...
  bool is_cure = false;           ///< ... unless, where this is set, the tets are worth more after it, in sum
  std::uint64_t face_target = 0;  ///< stop at the first state with at most so many boundary faces ...
  std::uint64_t tet_target = 0;   ///< ... or tets
  double longest = std::numeric_limits<double>::infinity();  ///< edges that are longer, over the relative
                                                             ///< size wanted at their middle, stay
};

/// What became of the candidates.
struct SurfaceReport {
  std::uint64_t collapses = 0;          ///< of boundary edges
  std::uint64_t splits = 0;             ///< of boundary edges
  std::uint64_t flips = 0;              ///< of boundary edges
  std::uint64_t moves = 0;              ///< of boundary vertices
  std::uint64_t rejected_link = 0;      ///< the mesh or its boundary would be no manifold
  std::uint64_t rejected_shape = 0;     ///< a tet would be inverted or too bad
  std::uint64_t rejected_distance = 0;  ///< the skins would be farther apart than the bound, or might be
  std::uint64_t rejected_contact = 0;   ///< the skin would run into itself
  std::uint64_t rejected_feature = 0;   ///< a sharp edge to keep would be too far from the input's
};

/// Collapses boundary edges, the shortest first (relative to the wanted size), until a target is reached or
/// nothing more can go. The new vertex is put where the planes of the faces around are nearest while the
/// volume is kept, or at one of the ends. A vertex on a feature line goes along the line only, and the line
/// stays within its limit; what collapses onto a line does not move it. Source: Lindstrom and Turk, IEEE
/// Visualization 1998, for the volume; Garland and Heckbert, SIGGRAPH 1997, for the planes.
void collapse_boundary_edges(WorkingMesh& mesh, GuardedBoundary& boundary, const ScoreRule& scores,
                             const SurfaceCollapseOptions& options, SurfaceReport& report);

}  // namespace palpate::simplify

// Splits of boundary edges under the guard of a GuardedBoundary.
#pragma once

#include <cstdint>
#include <limits>

#include "core/simplify/skin_guard/guarded_boundary.h"
#include "core/simplify/tet_operations/score_rule.h"
#include "core/simplify/tet_operations/working_mesh.h"

namespace palpate::simplify {

/// Which edges are split, and when enough are.
struct SurfaceSplitOptions {
  double shortest = 0.0;     ///< edges up to this length over the relative size wanted there stay
  double least_score = 0.0;  ///< a split may leave no tet below this
  std::uint64_t face_target = std::numeric_limits<std::uint64_t>::max();  ///< stop at so many boundary faces
  std::uint64_t tet_target = std::numeric_limits<std::uint64_t>::max();   ///< ... or tets
  std::uint64_t most_tets = std::numeric_limits<std::uint64_t>::max();    ///< no split leads beyond
};

/// Splits boundary edges in their middles, the longest over the sizes wanted first, as they are at the
/// beginning: what a split makes is not split again. The skin stays where it is, but for rounding, and the
/// guard is asked all the same. Feature edges and edges of kept tets stay. Returns:  how many were split.
std::uint64_t split_boundary_edges(WorkingMesh& mesh, GuardedBoundary& boundary, const ScoreRule& scores,
                                   const SurfaceSplitOptions& options);

}  // namespace palpate::simplify

// Edge collapses inside a tet mesh, shortest edge first.
#pragma once

#include <cstdint>
#include <limits>
#include <span>

#include "core/simplify/tet_operations/quality_floor.h"
#include "core/simplify/tet_operations/score_rule.h"
#include "core/simplify/tet_operations/working_mesh.h"

namespace palpate::simplify {

/// Where the vertex goes that an edge becomes. An end that may not move is the only place there is.
enum class CollapsePlacement {
  kFirst,    ///< the first that passes of midpoint, centroid of the link and both ends
  kBest,     ///< of the same places the one with the best worst score around
  kMidpoint  ///< the midpoint alone
};

/// Where edges collapse to, when one is refused, and when enough are.
struct CollapseOptions {
  CollapsePlacement placement = CollapsePlacement::kFirst;
  std::span<const double> least_scores;  ///< a collapse may leave no tet at or below the first of these;
                                         ///< where that leaves nothing to collapse, the next, which is less
  std::uint64_t target = 0;              ///< stop at the first state with at most so many tets
  const QualityFloor* floor = nullptr;   ///< a collapse may leave no tet below it, if there is one
  double longest = std::numeric_limits<double>::infinity();  ///< edges that are longer, over the relative
                                                             ///< size wanted at their middle, stay
};

/// What became of the candidates.
struct CollapseReport {
  std::uint64_t collapses = 0;
  std::uint64_t rejected_link = 0;   ///< times that the link condition did not hold
  std::uint64_t rejected_shape = 0;  ///< times that a tet would have become inverted or too bad
};

/// Collapses edges with at least one free end, the shortest first (relative to the wanted size at the
/// midpoint; ties by vertex numbers), until `target` is reached or nothing more can go. What was refused is
/// looked at again when all else is done and something around it has changed, or a lower score is permitted.
/// Every tet stays positive, exactly.
CollapseReport collapse_edges(WorkingMesh& mesh, const ScoreRule& rule, const CollapseOptions& options);

}  // namespace palpate::simplify

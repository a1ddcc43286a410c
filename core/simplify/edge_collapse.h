// Edge collapses inside a tet mesh, shortest edge first.
#pragma once

#include <cstdint>
#include <string_view>

#include "core/simplify/cone.h"
#include "core/simplify/sizing.h"
#include "core/simplify/working_mesh.h"

namespace palpate::simplify {

/// Where the vertex goes that an edge becomes.
enum class CollapsePlacement {
  kMidpoint,  ///< of two free ends; else the end that may not move
  kBest       ///< the best of midpoint, both ends and the centroid of the link, by the worst score around
};

struct CollapseOptions {
  CollapsePlacement placement = CollapsePlacement::kBest;
  double least_score = 0.0;  ///< a collapse may leave no tet below this, unless it was worse before
  std::uint64_t target = 0;  ///< stop at the first state with at most so many tets
};

/// What became of the candidates.
struct CollapseReport {
  std::uint64_t collapses = 0;
  std::uint64_t rejected_link = 0;   ///< the link condition does not hold
  std::uint64_t rejected_shape = 0;  ///< a tet would be inverted or too bad
};

/// Collapses edges with at least one free end, the shortest first (relative to the wanted size at the
/// midpoint), until `target` is reached or nothing more can go. An edge that was refused is looked at again
/// once the star of one of its ends has changed.
CollapseReport collapse_edges(WorkingMesh& mesh, const ScoreScale& scale, const SizingField& field,
                              const CollapseOptions& options);

}  // namespace palpate::simplify

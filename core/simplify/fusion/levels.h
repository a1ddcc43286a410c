// Levels: how many rings a tet lies away from the boundary (thesis 2.3.1).
#pragma once

#include <cstdint>
#include <vector>

#include "core/simplify/fusion/fusion.h"

namespace palpate::simplify {

/// What makes two tets neighbours. The thesis does not say; its pre-check 2 fits `vertex`.
enum class LevelAdjacency { kVertex, kEdge, kFace };

/// The level of a tet that no chain of neighbours joins to level 0.
inline constexpr std::uint16_t kNoLevel = 0xffff;

/// Levels of all tets.
///
///   level 0:      has a boundary vertex
///   level n + 1:  has no lower level, and shares a vertex (an edge, a face) with a tet of level n
///
/// Shape:    one entry a tet, in storage order. A tet that no chain of neighbours joins to level 0 has
/// kNoLevel. Requires: a mesh before its first fusion; one flag a vertex, by the input's numbers.
std::vector<std::uint16_t> build_levels(const FusionMesh& mesh,
                                        const std::vector<std::uint8_t>& is_boundary_vertex,
                                        LevelAdjacency adjacency);

/// Number of tets of each level, level 0 first; tets of kNoLevel are not counted.
std::vector<std::uint64_t> count_levels(const std::vector<std::uint16_t>& level);

}  // namespace palpate::simplify

// The order in which the plain engine keeps vertices and springs: a pass of its own that changes nothing but
// rounding.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/base/types.h"

namespace palpate::dynamics {

/// Up to four springs with one end in common, by their numbers; kNoIndex behind the last one.
struct SpringFan {
  Index hub = kNoIndex;  ///< the vertex at which they meet
  std::array<Index, 4> springs{kNoIndex, kNoIndex, kNoIndex, kNoIndex};
};

/// Where a spring is computed: vertices in curve order are cut into blocks of `block_vertices`, whatever the
/// number of threads. A spring within a block is computed once, by it; one between two blocks by both, each
/// for its own vertex. So no two blocks write to the same place.
///
/// Springs within a block come in fans, so that a vertex is read and its force written once for four. Each
/// vertex in turn takes what it can of its springs in fours and leaves the rest to later vertices; a fan that
/// is not full is left only where there is no later one.
///
/// Shape:  inside[b] and across[b] hold springs of block b; `across` is for the vertex that lies in b. Within
///         each list springs are sorted by their vertices in curve order, then dealt out so that eight
///         entries that follow each other come from eight parts of the list and rarely share a vertex.
struct SpringBlocks {
  std::size_t block_vertices = 0;
  std::vector<std::vector<SpringFan>> inside;
  std::vector<std::vector<Index>> across;
};

/// `place` is the inverse of the order: place[v] is where vertex v comes.
SpringBlocks build_spring_blocks(std::span<const Edge> springs, std::span<const Index> place,
                                 std::size_t block_vertices);

}  // namespace palpate::dynamics

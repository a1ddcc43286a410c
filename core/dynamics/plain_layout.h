// The order in which the plain engine keeps vertices and springs: a pass of its own that changes nothing but
// rounding.
#pragma once

#include <span>
#include <vector>

#include "core/base/types.h"

namespace palpate::dynamics {

/// Vertices along Morton's curve through their bounding box, 21 bits an axis; ties by number. Neighbours in
/// space are then mostly neighbours in memory.
///
/// Returns: order[k], the vertex that comes k-th.
std::vector<Index> order_along_morton_curve(std::span<const Vec3> points);

/// Where a spring is computed: vertices in curve order are cut into blocks of `block_vertices`, whatever the
/// number of threads. A spring within a block is computed once, by it; one between two blocks by both, each
/// for its own vertex. So no two blocks write to the same place.
///
/// Shape:  inside[b] and across[b] hold springs of block b by their number; `across` is for the vertex that
///         lies in b. Within each list springs are sorted by their vertices in curve order, then dealt out so
///         that eight that follow each other come from eight parts of the list and rarely share a vertex.
struct SpringBlocks {
  std::size_t block_vertices = 0;
  std::vector<std::vector<Index>> inside;
  std::vector<std::vector<Index>> across;
};

/// `place` is the inverse of the order: place[v] is where vertex v comes.
SpringBlocks build_spring_blocks(std::span<const Edge> springs, std::span<const Index> place,
                                 std::size_t block_vertices);

}  // namespace palpate::dynamics

// The order in which the tet engine keeps its domains: a pass of its own that changes nothing but rounding.
#pragma once

#include <span>
#include <vector>

#include "core/dynamics/elasticity/elastic_model.h"

namespace palpate::dynamics {

/// Domains of one term with at most so many vertices, eight of which make a group.
struct DomainClass {
  std::size_t vertices = 0;
  std::vector<Index> domains;
};

/// What a block computes.
///
/// Shape:  halo holds the places of the vertices of other blocks that its domains have, increasing; terms one
///         list a strain term.
struct DomainBlock {
  std::vector<Index> halo;
  std::vector<std::vector<DomainClass>> terms;
};

/// Vertices in curve order are cut into blocks of `block_vertices`, whatever the number of threads. A domain
/// is computed once, by the block that has most of its vertices (of several such the first); what it does to
/// the others, in the halo, the block leaves for theirs to add.
///
/// Domains of a class are sorted by their first vertex in curve order, then dealt out so that eight that
/// follow each other come from eight parts of the list and rarely share a vertex. Domains without vertices
/// are left out.
struct DomainBlocks {
  std::size_t block_vertices = 0;
  std::vector<DomainBlock> blocks;
};

/// `place` is the inverse of the order: place[v] is where vertex v comes.
DomainBlocks build_domain_blocks(std::span<const StrainTerm> terms, std::span<const Index> place,
                                 std::size_t block_vertices);

}  // namespace palpate::dynamics

// The tractions that a table knows, and what they do to the nodes of the elements.
#pragma once

#include <vector>

#include "core/dynamics/finite_elements/elements.h"

namespace palpate::dynamics {

/// The nodes of the skin that carry forces: its vertices, then, for quadratic tractions, the midpoints of its
/// edges.
struct SkinNodes {
  std::vector<Index> vertices;  ///< of the mesh, rising
  std::vector<Edge> edges;      ///< of the mesh, sorted; empty for linear tractions
  std::size_t size() const { return vertices.size() + edges.size(); }
};

/// The skin's nodes by the numbers that they have among the nodes of an element space of the same order on
/// the same mesh.
///
/// Shape:  place has one entry a node of that space: its place in SkinNodes, or kNoIndex.
struct SkinPlaces {
  SkinNodes nodes;
  std::vector<Index> place;
};
/// Numbers the skin's nodes for tractions of the order of `space`.
SkinPlaces number_skin(const TetMesh& mesh, const ElementSpace& space);

/// One entry of a sparse column.
struct NodeWeight {
  Index node = 0;
  double weight = 0.0;
};

/// The coupling of tractions and elements.
///
/// Shape:  coupling has one column a node of the skin: the integrals of psi times each element shape function
///         that is not zero there; mass the columns of their Gram matrix. Where the tractions are those of
///         the elements themselves, a force on a node is the node's own: the columns are unit vectors and
///         mass is empty.
struct SkinCoupling {
  std::vector<std::vector<NodeWeight>> coupling;
  std::vector<std::vector<NodeWeight>> mass;
};

/// `coarse` is the space of the tractions on `mesh`, `fine` that of the elements on `fine_mesh`, which is
/// `mesh` or its uniform refinement. Exact. Requires: coarse.order <= fine.order.
SkinCoupling couple_skin(const TetMesh& mesh, const ElementSpace& coarse, const TetMesh& fine_mesh,
                         const ElementSpace& fine, const SkinPlaces& skin);

}  // namespace palpate::dynamics

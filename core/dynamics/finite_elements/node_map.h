// Spaces within a space of elements: nodes that follow others.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/dynamics/finite_elements/elements.h"

namespace palpate::dynamics {

/// All nodes of a space from those that are unknown: u_all = T u. Each unknown is one of the nodes.
///
/// Shape:  row i of T, of node i, is unknowns and weights from offsets[i] to offsets[i + 1]; nodes has one
///         entry an unknown: the node that it is.
struct NodeMap {
  std::vector<std::size_t> offsets{0};
  std::vector<Index> unknowns;
  std::vector<double> weights;
  std::vector<Index> nodes;

  std::size_t rows() const { return offsets.size() - 1; }
};

/// Quadratic elements some of whose midpoints follow: one without a flag is the mean of its edge's ends, so
/// the field is linear along that edge. The space is that of the linear functions of all vertices and of
/// 4 phi_a phi_b on the edges with a flag. It conforms: two tets see the same field on a face between them.
///
/// Shape:  own has one entry an edge of the space. Unknowns are the vertices, then the flagged midpoints.
/// Throws: ContractError unless the space is of order 2.
NodeMap follow_edges(const ElementSpace& space, std::span<const std::uint8_t> own);

/// The linear functions of a mesh in the quadratic elements of a finer one: `space` has its `vertices`
/// vertices first, then for each edge of `halved` its midpoint (both ends come before it), then the midpoints
/// of its own edges. With nothing halved it is follow_edges without a flag.
///
/// Requires: each edge of the space lies within one tet of the coarse mesh, as it does after
///           refine_uniformly (halved = build_edges(mesh)) and bisect_edges.
NodeMap embed_linear(const ElementSpace& space, std::size_t vertices, std::span<const Edge> halved);

/// T u.
std::vector<Vec3> apply_map(const NodeMap& map, std::span<const Vec3> u);
/// T^T f.
std::vector<Vec3> apply_transposed(const NodeMap& map, std::span<const Vec3> f);
/// T^T A T; the matrix has the pattern of the space's elements.
BlockMatrix restrict_matrix(const NodeMap& map, const ElementSpace& space, const BlockMatrix& matrix);

/// One flag a vertex: 1 on a face that is held, supported or loaded, and where a force acts.
std::vector<std::uint8_t> find_touched(std::size_t vertices, const BoundaryProblem& problem);

/// One flag an edge: 1 if both ends are at most `rings` edges away from a touched vertex. None for -1.
std::vector<std::uint8_t> find_edges_near(const EdgeNumbers& edges, std::span<const std::uint8_t> touched,
                                          int rings);

}  // namespace palpate::dynamics

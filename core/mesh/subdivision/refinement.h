// Uniform refinement: each tet into eight, and what lies on the mesh handed down to the children.
#pragma once

#include <span>
#include <vector>

#include "core/mesh/boundary_problem.h"
#include "core/mesh/tet_mesh.h"

namespace palpate {

/// The edges of a mesh with a look-up by their ends.
///
/// Shape:  edges as build_edges gives them; offsets has one entry a vertex and one more: the edges whose
///         smaller end is v are edges[offsets[v] .. offsets[v + 1]).
struct EdgeNumbers {
  std::vector<Edge> edges;
  std::vector<Index> offsets;

  /// Place of the edge in build_edges(mesh), or kNoIndex if the mesh has no such edge. Logarithmic in the
  /// number of edges at one vertex.
  Index of(Index a, Index b) const;
};
/// Numbers the edges as build_edges does. Linear memory, n log n time.
EdgeNumbers build_edge_numbers(const TetMesh& mesh);

/// Splits each tet into eight of the same volume: four corners, and the inner octahedron along the shortest
/// of its three diagonals; of equally long ones the one with the smallest vertex numbers.
///
/// Vertices keep their numbers; the midpoint of edge i of build_edges(mesh) becomes vertex points.size() + i.
/// Tet t has the children 8 t .. 8 t + 7, positively oriented like t (but for rounding, in a tet that is flat
/// to the last bit). The four corner children are similar to their parent. With the shortest diagonal the
/// shapes of the inner ones stay bounded over any number of refinements: proven where no dihedral angle is
/// obtuse, measured elsewhere.
/// Throws: InputError if the result would have 2^30 tets or more, or 2^32 - 1 vertices.
/// Source: J. Bey, Tetrahedral grid refinement, Computing 55 (1995); the diagonal: S. Zhang, Houston J. Math.
///         21 (1995), 541-556.
TetMesh refine_uniformly(const TetMesh& mesh);

/// The four children of each triangle, at 4 i .. 4 i + 3: the corners in order, then the middle; turned like
/// their parent. `edges` are those of the unrefined mesh with `vertices` vertices. Throws: ContractError if a
/// side of a triangle is no edge.
std::vector<Triangle> refine_triangles(std::span<const Triangle> triangles, const EdgeNumbers& edges,
                                       std::size_t vertices);

/// A quadratic field, one value a vertex and one an edge midpoint of `mesh`, at the vertices and edge
/// midpoints of `refined` = refine_uniformly(mesh): the same function. Throws: ContractError if the sizes
/// differ.
std::vector<Vec3> refine_quadratic_field(const TetMesh& mesh, const TetMesh& refined,
                                         std::span<const Vec3> field);

/// The same problem on refine_uniformly(mesh): each face hands its weight, its load and what holds it to its
/// four children; forces stay on their vertices; fields are evaluated. So a region is the same on every
/// level.
BoundaryProblem refine_problem(const BoundaryProblem& problem, const TetMesh& mesh, const TetMesh& refined);

}  // namespace palpate

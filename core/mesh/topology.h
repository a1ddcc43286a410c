// Topology of a tet mesh, built by value; nothing is cached in the mesh.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/mesh/tet_mesh.h"

namespace palpate {

/// Tets around each vertex, in compressed rows.
///
/// Shape:  offsets has one entry a vertex and one more; tets[offsets[v] .. offsets[v + 1]) holds the tets of
///         vertex v in increasing order.
struct VertexStars {
  std::vector<Index> offsets;
  std::vector<Index> tets;

  std::span<const Index> of(Index vertex) const {
    return {tets.data() + offsets[vertex], tets.data() + offsets[vertex + 1]};
  }
};

/// Builds the vertex stars. Linear time and memory. Here and below, any number of threads gives the same.
/// Requires: every index of mesh.tets is below mesh.points.size(); fewer than 2^30 tets.
VertexStars build_vertex_stars(const TetMesh& mesh, int threads = 1);

/// The edges of the mesh, each once, a < b, sorted.
std::vector<Edge> build_edges(const TetMesh& mesh);

/// A face and its one or two tets; tets[1] is kNoIndex on the boundary. `vertices` is sorted.
struct Face {
  Triangle vertices;
  std::array<Index, 2> tets;
};

/// The faces of the mesh, each once, sorted by their sorted vertices.
/// Throws: InputError if a face has more than two tets.
std::vector<Face> build_faces(const TetMesh& mesh);

/// The faces that have one tet only, counter-clockwise seen from outside, in the order of (tet, local face).
/// Linear memory, n log n time at worst.
/// Throws: InputError if a face has more than two tets, or two tets on the same side.
std::vector<Triangle> build_boundary(const TetMesh& mesh, int threads = 1);

/// The faces that have one tet only, as build_boundary gives them, of any mesh: faces with more tets are left
/// out, however the tets lie. For output; algorithms want build_boundary.
std::vector<Triangle> build_unpaired_faces(const TetMesh& mesh);

/// One flag a vertex: 1 if it lies on a boundary face.
std::vector<std::uint8_t> build_boundary_vertex_flags(const TetMesh& mesh, int threads = 1);

/// Removes the vertices that no tet uses; the others keep their order. Returns how many were removed.
std::size_t remove_isolated_vertices(TetMesh& mesh);

}  // namespace palpate

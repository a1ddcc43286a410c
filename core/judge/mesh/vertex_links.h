// Vertex stars and links: the judge's own topology. Whatever it asks of faces, edges and vertices is read off
// the link of one vertex after another, so that the memory beside the stars is that of one link.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/mesh/tet_mesh.h"

namespace palpate::judge {

/// Whether the four indices of a tet are below `points` and differ.
bool has_valid_indices(const Tet& tet, std::size_t points);

/// The tets with valid indices around each vertex, in compressed rows: those of vertex v in increasing order
/// are tets[offsets[v] .. offsets[v + 1]). Tets with invalid indices are in no star.
struct Stars {
  std::vector<std::size_t> offsets;
  std::vector<Index> tets;

  std::span<const Index> of(Index vertex) const {
    return {tets.data() + offsets[vertex], offsets[vertex + 1] - offsets[vertex]};
  }
};
/// The stars of all vertices. Linear time and memory.
Stars build_stars(const TetMesh& mesh);

/// A side of a link triangle: the face (v, low, high) of `tet`, v being the vertex whose link it is.
struct LinkSide {
  Index low = 0;  ///< low < high
  Index high = 0;
  Index tet = 0;
  Index triangle = 0;   ///< position of the tet in the star of v
  bool upward = false;  ///< the triangle, seen from outside the tet, is passed from low to high
};

/// A run of sides with the same ends: one face of the mesh, seen from v, with the tets that have it.
using LinkFace = std::span<const LinkSide>;

/// The link of one vertex: the triangles opposite to it in the tets around it, as a surface. One object
/// serves for many vertices, one after another.
class VertexLink {
 public:
  VertexLink(const TetMesh& mesh, const Stars& stars);

  /// Takes up the link of `vertex`.
  void move_to(Index vertex);

  Index vertex() const { return vertex_; }
  std::size_t triangles() const { return star_.size(); }
  std::span<const Index> star() const { return star_; }

  /// The vertices of the link, each once. With v they make the edges of the mesh at v.
  std::span<const Index> vertices() const { return vertices_; }

  /// The vertices of `star()[triangle]` without v, counter-clockwise seen from outside.
  const Triangle& triangle(std::size_t triangle) const { return corners_[triangle]; }

  /// Calls visit(LinkFace) for each face at v, in the order of (low, high).
  template <typename Visit>
  void for_each_face(Visit&& visit) const {
    for (std::size_t first = 0; first < sides_.size();) {
      std::size_t last = first + 1;
      while (last < sides_.size() && sides_[last].low == sides_[first].low &&
             sides_[last].high == sides_[first].high) {
        ++last;
      }
      visit(LinkFace(sides_.data() + first, last - first));
      first = last;
    }
  }

  /// The outward orientation of the face that `side` stands for.
  Triangle outward_face(const LinkSide& side) const {
    return side.upward ? Triangle{vertex_, side.high, side.low} : Triangle{vertex_, side.low, side.high};
  }

 private:
  const TetMesh* mesh_;
  const Stars* stars_;
  Index vertex_ = kNoIndex;
  std::span<const Index> star_;
  std::vector<Triangle> corners_;
  std::vector<LinkSide> sides_;
  std::vector<Index> vertices_;
  Index visit_ = 0;
  std::vector<Index> seen_at_;  // one a vertex of the mesh: the last visit whose link had it
};

/// Calls visit(Triangle) for each face that one tet alone has, counter-clockwise seen from outside, in the
/// order of their smallest vertices.
template <typename Visit>
void for_each_boundary_face(const TetMesh& mesh, Visit&& visit) {
  const Stars stars = build_stars(mesh);
  VertexLink link(mesh, stars);
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    link.move_to(static_cast<Index>(v));
    link.for_each_face([&](LinkFace face) {
      if (face.size() == 1 && link.vertex() <= face[0].low) visit(link.outward_face(face[0]));
    });
  }
}

/// Disjoint sets over 0 .. size - 1.
class DisjointSets {
 public:
  void reset(std::size_t size);
  Index root(Index item);

  /// Joins two sets. Returns whether they were different.
  bool join(Index a, Index b);

 private:
  std::vector<Index> parent_;
};

}  // namespace palpate::judge

// A tet mesh that changes under local operations: the common ground of palpate.refined and palpate.surface.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/mesh/tet_mesh.h"
#include "core/simplify/sizing/sizing.h"

namespace palpate::simplify {

/// What a vertex may do.
enum VertexFlag : std::uint8_t {
  kFree = 0,
  kOnBoundary = 1,  ///< lies on a boundary face
  kFrozen = 2       ///< belongs to a kept tet: neither moves nor vanishes
};

/// A tet mesh under local operations. Dead tets and vertices are marked and their slots are used again; the
/// star of each vertex, the tets around it, is kept up to date.
///
/// Vertices are stored along a space-filling curve, tets by their smallest vertex: neighbours in space are
/// neighbours in memory. `vertex_origin` leads back to the input's numbers (kNoIndex for a vertex that was
/// added). `score` is scratch for callers, one entry a tet: each operation sets it to kNoScore for the tets
/// that it changed.
/// Memory: 36 bytes a tet, about 90 a vertex. Stars lie in parts, each laid out anew by itself when it is
/// full.
struct WorkingMesh {
  static constexpr float kNoScore = -1.0F;
  static constexpr Index kVerticesOfPart = 1024;

  std::vector<Vec3> points;
  std::vector<Tet> tets;                      ///< a dead tet has kNoIndex as its first vertex
  std::vector<float> score;                   ///< one a tet; kNoScore where unknown
  std::vector<std::uint8_t> vertex_flags;     ///< of VertexFlag
  std::vector<Index> vertex_origin;           ///< number in the input
  std::vector<std::uint8_t> kept_tets;        ///< 1: never dies and never changes; empty: there are none
  std::vector<std::vector<Index>> star_rows;  ///< the stars of kVerticesOfPart vertices after another each
  std::vector<Index> star_begin;              ///< where in these a vertex's star begins
  std::vector<Index> star_size;               ///< 0: the vertex is dead
  std::vector<Index> star_capacity;
  std::vector<Index> free_tets;      ///< dead slots, the last one is used first
  std::vector<Index> free_vertices;  ///< dead slots of vertices
  std::size_t alive = 0;             ///< tets

  bool is_alive(Index t) const { return tets[t][0] != kNoIndex; }
  bool is_vertex_alive(Index v) const { return star_size[v] > 0; }
  bool is_on_boundary(Index v) const { return (vertex_flags[v] & kOnBoundary) != 0; }
  /// Neither on the boundary nor frozen: it may move and vanish.
  bool is_free(Index v) const { return vertex_flags[v] == kFree; }
  bool is_kept(Index t) const { return t < kept_tets.size() && kept_tets[t] != 0; }
  std::vector<Index>& rows_of(Index v) { return star_rows[v / kVerticesOfPart]; }
  const std::vector<Index>& rows_of(Index v) const { return star_rows[v / kVerticesOfPart]; }
  std::span<const Index> star(Index v) const { return {rows_of(v).data() + star_begin[v], star_size[v]}; }
  std::span<Index> star(Index v) { return {rows_of(v).data() + star_begin[v], star_size[v]}; }
};

/// Takes a mesh over (its arrays are released) and marks boundary vertices and what `field` keeps. An empty
/// field costs nothing.
/// Throws: InputError if a face has more than two tets, or two tets on the same side.
WorkingMesh build_working_mesh(TetMesh&& mesh, const SizingField& field);

/// The mesh that is left, in a well-defined order: vertices as in the input, added ones behind; tets by their
/// smallest vertex, those with the same one by their slots. Empties `mesh`.
TetMesh extract_mesh(WorkingMesh&& mesh);

/// Moves vertex v; the scores around it become unknown.
void apply_move(WorkingMesh& mesh, Index v, const Vec3& to);

/// Collapses edge (gone, survivor): the tets that have both die, in the others `gone` becomes `survivor`,
/// which moves to `to`. Flags stay those of `survivor`. Requires: the edge exists and meets the link
/// condition (see meets_link_condition); no tet that dies is kept. The caller has made sure that the tets
/// left are positive. Returns:  how many tets died.
std::size_t apply_collapse(WorkingMesh& mesh, Index gone, Index survivor, const Vec3& to);

/// Replaces a set of tets by another that fills the same space, such as a flip does. `added` gets the slots
/// of `fresh`, in the same order. No vertex may lose its last tet. Requires: the tets of `old` are alive and
/// not kept.
void apply_flip(WorkingMesh& mesh, std::span<const Index> old, std::span<const Tet> fresh,
                std::vector<Index>& added);

/// Adds a vertex without tets, free to move; tets that name it come by apply_flip. Returns its number.
Index add_vertex(WorkingMesh& mesh, const Vec3& at);

/// Gives up a vertex that has no tet.
void remove_vertex(WorkingMesh& mesh, Index v);

/// The tets that have both a and b, appended to `result` after it is cleared.
void collect_edge_star(const WorkingMesh& mesh, Index a, Index b, std::vector<Index>& result);

/// The corner of a tet that is v. Requires: one is.
inline std::size_t corner_in(const Tet& tet, Index v) {
  return static_cast<std::size_t>(std::find(tet.begin(), tet.end(), v) - tet.begin());
}

/// The face opposite to a corner of a tet, counter-clockwise seen from outside: (corner, face) has the tet's
/// orientation.
inline Triangle face_opposite(const Tet& tet, std::size_t corner) {
  const auto& local = kTetFaces[corner];
  return {tet[static_cast<std::size_t>(local[0])], tet[static_cast<std::size_t>(local[1])],
          tet[static_cast<std::size_t>(local[2])]};
}

/// The slot of the tet with these vertices, in any order. Throws: ContractError if there is none.
Index find_tet(const WorkingMesh& mesh, const Tet& tet);

/// The other tet with face (a, b, c) than `tet`; kNoIndex on the boundary.
Index neighbour_across(const WorkingMesh& mesh, Index tet, Index a, Index b, Index c);

/// The boundary faces at vertex v, counter-clockwise seen from outside, v first. `result` is cleared first.
void collect_boundary_faces(const WorkingMesh& mesh, Index v, std::vector<Triangle>& result);

/// Marks for vertices that cost nothing to clear.
class VertexMarks {
 public:
  /// Forgets all marks and makes room for `vertices` vertices.
  void clear(std::size_t vertices) {
    if (stamp_of_.size() < vertices) stamp_of_.resize(vertices, 0);
    if (stamp_ > 0xffffffffU - 4U) {
      stamp_of_.assign(stamp_of_.size(), 0);
      stamp_ = 0;
    }
    stamp_ += 4;
  }
  /// Gives v the mark 1, 2 or 3.
  void set(Index v, std::uint32_t mark) { stamp_of_[v] = stamp_ + mark; }
  /// The mark of v, 0 if it has none.
  std::uint32_t of(Index v) const { return stamp_of_[v] > stamp_ ? stamp_of_[v] - stamp_ : 0; }

 private:
  std::vector<std::uint32_t> stamp_of_;
  std::uint32_t stamp_ = 0;
};

/// Whether collapsing edge (gone, survivor) keeps the mesh a manifold: the links of the two ends have no
/// vertex and no edge in common but those of the edge's own link. For an edge inside (one end may be on the
/// boundary) this is the whole condition; between two boundary vertices the caller must also see to the
/// boundary's own link condition.
/// Source: Dey, Edelsbrunner, Guha and Nekhayev, Publ. Inst. Math. 66 (1999).
bool meets_link_condition(const WorkingMesh& mesh, Index gone, Index survivor, VertexMarks& marks);

}  // namespace palpate::simplify

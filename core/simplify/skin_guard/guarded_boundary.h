// The boundary faces of a mesh under local operations, with a guard over them: no part of the skin leaves the
// input's by more than a bound, nor the input's leaves it, and no two faces run into each other.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/simplify/cover/cover_check.h"
#include "core/simplify/cover/sheet_cover.h"
#include "core/simplify/skin_guard/face_contact.h"
#include "core/simplify/skin_guard/feature_lines.h"
#include "core/simplify/skin_guard/input_skin.h"
#include "core/simplify/tet_operations/working_mesh.h"

namespace palpate::simplify {

/// Whether `v` is a corner of the face.
constexpr bool has_corner(const Triangle& face, Index v) {
  return face[0] == v || face[1] == v || face[2] == v;
}

/// Faces that would go and faces that would come in their place, with one vertex moved. The outline of both
/// sets is the same.
struct BoundaryChange {
  std::vector<Index> removed;   ///< numbers of faces
  std::vector<Triangle> fresh;  ///< the i-th takes the number of the i-th removed one, or a new one
  Index moved = kNoIndex;       ///< the only vertex of `fresh` that has another place, or none ...
  Vec3 to;                      ///< ... namely this one
};

/// What speaks against a change.
enum class BoundaryVerdict {
  kAllowed,
  kTooFar,  ///< the distance to the input's skin would exceed the bound, or is not proven not to
  kContact  ///< it would not, but a face would touch another one
};

/// Current boundary faces, found by vertex and by place.
class GuardedBoundary {
 public:
  /// Takes the boundary of the mesh as the input's skin. `max_error` in the mesh's unit; below rounding
  /// (1e-13 of the largest coordinate) it is taken for that. Edges sharper than `feature_deg` are lines to
  /// keep (FeatureLines), within the same bound; 0: none.
  GuardedBoundary(const WorkingMesh& mesh, double max_error, double feature_deg = 0.0);

  /// Changes the bound for what comes. It may only grow: what was proven for a smaller one still holds.
  void raise_bound(const WorkingMesh& mesh, double max_error);

  /// Takes over new numbers of the vertices, of a mesh with the same boundary: new_number[v] is that of v.
  void renumber(const std::vector<Index>& new_number, std::size_t vertices);

  std::size_t size() const { return alive_; }
  std::size_t slots() const { return faces_.size(); }
  bool is_alive(Index f) const { return faces_[f][0] != kNoIndex; }
  const Triangle& face(Index f) const { return faces_[f]; }
  std::span<const Index> faces_of(Index v) const { return of_vertex_[v]; }

  /// Calls visit(a, b), a < b, for each edge of the faces, in their order. `visit` changes none of them.
  template <typename Visit>
  void for_each_edge(const Visit& visit) const {
    for (Index f = 0; f < slots(); ++f) {
      const Triangle& t = faces_[f];
      for (std::size_t k = 0; k < 3 && is_alive(f); ++k) {
        const Index next = t[(k + 1) % 3];
        if (t[k] < next) visit(t[k], next);  // the other face has it the other way round
      }
    }
  }

  /// The sharp edges to keep. The guard does not ask them by itself: a collapse along one does
  /// (permits_collapse), and nothing else may take away or move what has a rank.
  const FeatureLines& lines() const { return lines_; }
  FeatureLines& lines() { return lines_; }

  /// The volume inside the faces.
  double volume(const WorkingMesh& mesh) const;

  /// The middle of a face that is in contact with another one now, if there is one. Time: linear in the faces
  /// where few meet.
  std::optional<Vec3> find_contact() const;

  /// Whether a change keeps two-sided distance and embedding. Remembers the proof for apply().
  BoundaryVerdict check(const WorkingMesh& mesh, const BoundaryChange& change);

  /// Carries out the change that was checked last; the caller does so in the mesh.
  void apply(const BoundaryChange& change);

 private:
  /// A triangle of the input's skin that a change concerns, and the current faces that would cover it.
  struct Proof {
    Index input = 0;
    std::vector<Index> covering;  ///< numbers of faces, as they are after the change
  };

  void make_room(std::size_t faces);
  bool touches_others();
  bool touches(std::size_t fresh);
  bool may_stay_near();
  bool reaches_beyond_limit() const;
  void lay_tiles();
  void lay_input_tiles();
  bool input_stays_near(const BoundaryChange& change);
  bool stays_near_input();
  void widen_concerned();
  void place_fresh(const WorkingMesh& mesh, const BoundaryChange& change);
  void collect_concerned(const BoundaryChange& change);
  void collect_around(const BoundaryChange& change);
  void add_around(Index f);
  PlacedFace placed(Index f) const { return {faces_[f], places_[f].corner}; }
  bool is_removed(Index f) const { return removed_stamp_[f] == stamp_; }
  void link(Index f);
  void unlink(Index f);
  template <typename Visit>
  void for_each_cell(const BoundingBox& box, const Visit& visit) const;
  void enter_grid(Index f);
  void leave_grid(Index f);

  std::vector<Triangle> faces_;
  std::vector<std::vector<Index>> of_vertex_;
  std::size_t alive_ = 0;
  FeatureLines lines_;

  InputSkin input_;
  CoverTest cover_;
  SheetCover sheet_;
  std::vector<std::vector<Index>> covering_;  // of each input triangle: faces whose union is within the bound
  std::vector<std::vector<Index>> covered_by_;  // of each face: input triangles; may hold some of long ago

  double cell_ = 1.0;
  std::vector<std::vector<Index>> cells_;  // by hash: faces whose box meets the cell
  std::vector<BoxedTriangle> places_;      // of each face

  // The change under examination.
  std::vector<PlacedFace> fresh_;
  std::vector<Index> concerned_;
  std::vector<Index> around_;
  std::vector<BoxedTriangle> candidates_;
  bool is_seen_ = false;           // along a direction: there are tiles
  std::vector<Tile> face_tiles_;   // of the candidates
  std::vector<Tile> input_tiles_;  // of those concerned
  std::vector<std::size_t> open_faces_;
  std::vector<Index> used_;
  std::vector<Proof> proofs_;
  std::size_t proof_count_ = 0;
  std::uint32_t stamp_ = 0;
  std::vector<std::uint32_t> removed_stamp_;
  std::vector<std::uint32_t> seen_stamp_;
  std::uint64_t visit_ = 0;  ///< of the face whose surroundings are looked through
  std::vector<std::uint64_t> visited_;
  std::vector<std::uint32_t> input_stamp_;
  std::vector<std::uint32_t> point_stamp_;  ///< of the input's vertices
};

/// How much a vertex is held: frozen ones stay like corners.
FeatureRank hold_on(const WorkingMesh& mesh, const GuardedBoundary& boundary, Index v);

}  // namespace palpate::simplify

// The faces of a skin that changes, by number, by vertex and by place, and a change of some of them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/types.h"
#include "core/simplify/cover/cover_check.h"
#include "core/simplify/skin_guard/face_contact.h"
#include "core/simplify/tet_operations/working_mesh.h"

namespace palpate::simplify {

/// Whether `v` is a corner of the face.
constexpr bool has_corner(const Triangle& face, Index v) {
  return face[0] == v || face[1] == v || face[2] == v;
}

/// Takes an item out of a list in which it is once; the last one takes its place. Throws: ContractError if it
/// is not there.
void erase_one(std::vector<Index>& items, Index item);

/// Faces that would go and faces that would come in their place, with one vertex moved. The outline of both
/// sets is the same.
struct BoundaryChange {
  std::vector<Index> removed;   ///< numbers of faces
  std::vector<Triangle> fresh;  ///< the i-th takes the number of the i-th removed one, or a new one
  Index moved = kNoIndex;       ///< the only vertex of `fresh` that has another place, or none ...
  Vec3 to;                      ///< ... namely this one

  /// The number that a fresh face gets, where there are numbers below `slots` before it.
  Index number_of_fresh(std::size_t i, std::size_t slots) const {
    return i < removed.size() ? removed[i] : static_cast<Index>(slots + i - removed.size());
  }
};

/// Current faces. What is gone keeps its number until another one takes it.
class SkinFaces {
 public:
  /// The boundary of the mesh.
  explicit SkinFaces(const WorkingMesh& mesh);

  std::size_t alive() const { return alive_; }
  std::size_t slots() const { return faces_.size(); }
  bool is_alive(Index f) const { return faces_[f][0] != kNoIndex; }
  const Triangle& face(Index f) const { return faces_[f]; }
  const std::vector<Triangle>& all() const { return faces_; }
  std::span<const Index> of_vertex(Index v) const { return of_vertex_[v]; }
  const BoxedTriangle& place(Index f) const { return places_[f]; }
  PlacedFace placed(Index f) const { return {faces_[f], places_[f].corner}; }

  /// Room for so many vertices at least.
  void make_room(std::size_t vertices);
  /// Takes over new numbers of the vertices: new_number[v] is that of v.
  void renumber(const std::vector<Index>& new_number, std::size_t vertices);
  void remove(Index f);
  /// `f`: the number of one that is gone, or the next one.
  void enter(Index f, const Triangle& face, const BoxedTriangle& place);

 private:
  void link(Index f);

  std::vector<Triangle> faces_;
  std::vector<std::vector<Index>> of_vertex_;
  std::vector<BoxedTriangle> places_;
  std::size_t alive_ = 0;
};

/// A change with the places that its fresh faces would have, and what it takes away.
class PlannedChange {
 public:
  /// Requires: the numbers of the change are those of `faces`. It has to stay as it is.
  void plan(const WorkingMesh& mesh, const SkinFaces& faces, const BoundaryChange& change);

  const BoundaryChange& change() const { return *change_; }
  bool is_removed(Index f) const { return f < removed_.size() && removed_[f].plan == plan_; }
  /// Of a face that is removed: its place in the change.
  std::size_t place_of(Index f) const { return removed_[f].place; }
  const std::vector<PlacedFace>& fresh() const { return fresh_; }
  /// Of the fresh faces.
  const std::vector<BoxedTriangle>& boxed() const { return boxed_; }

 private:
  const BoundaryChange* change_ = nullptr;
  std::vector<PlacedFace> fresh_;
  std::vector<BoxedTriangle> boxed_;
  struct Removed {
    std::uint32_t plan = 0;
    std::uint32_t place = 0;
  };
  std::uint32_t plan_ = 0;
  std::vector<Removed> removed_;  ///< of each face: the last plan that takes it away
};

}  // namespace palpate::simplify

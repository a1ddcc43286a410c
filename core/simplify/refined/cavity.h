// Room for a new vertex: what helps a tet whose corners all lie on the skin.
#pragma once

#include <cstddef>
#include <vector>

#include "core/simplify/tet_operations/score_rule.h"
#include "core/simplify/tet_operations/working_mesh.h"

namespace palpate::simplify {

/// What the tets between a new vertex and the faces around it have to score.
struct CavityScores {
  double inside = 0.0;   ///< behind a face with another tet behind it
  double on_skin = 0.0;  ///< on a face of the boundary, which has to stay
};

/// A set of tets that gives way to those between a new vertex and the faces that bound the set. It is grown
/// as in Delaunay insertion, but by scores.
/// Source: Klingner and Shewchuk, "Aggressive tetrahedral mesh improvement" (2007).
class Cavity {
 public:
  /// Holds references to both.
  Cavity(const WorkingMesh& mesh, const ScoreRule& scores) : mesh_(mesh), scores_(scores) {}

  /// Grows the set from tet `seed` for a vertex at `place`: wherever the tet on a face would not score what
  /// it has to, the tet behind that face is taken too. Returns whether this ends: with no face of the
  /// boundary and no kept tet in the way, with kMostTets at most, and with no vertex in the middle.
  bool grow(Index seed, const Vec3& place, const CavityScores& least);

  const std::vector<Index>& tets() const { return tets_; }
  /// The faces (a, b, c) that bound the set, such that (place, a, b, c) is positive.
  const std::vector<Triangle>& faces() const { return faces_; }

  static constexpr std::size_t kMostTets = 40;

 private:
  bool has(Index t) const;
  void drop_inner_faces();
  bool is_vertex_lost() const;

  const WorkingMesh& mesh_;
  const ScoreRule& scores_;
  std::vector<Index> tets_;
  std::vector<Triangle> faces_;
  std::vector<Index> behind_;  ///< the tet behind each face while the set grows
};

/// Where a vertex may help tet t: at some heights above each of its faces on the boundary, and in the middle
/// of the tet behind each other face. `places` is cleared first.
void propose_places(const WorkingMesh& mesh, Index t, std::vector<Vec3>& places);

}  // namespace palpate::simplify

// The boundary faces of a mesh under local operations, with a guard over them: no part of the skin leaves the
// input's by more than a bound, nor the input's leaves it, and no two faces run into each other.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "core/simplify/skin_guard/face_grid.h"
#include "core/simplify/skin_guard/feature_lines.h"
#include "core/simplify/skin_guard/skin_distance.h"
#include "core/simplify/skin_guard/skin_faces.h"
#include "core/simplify/tet_operations/working_mesh.h"

namespace palpate::simplify {

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

  std::size_t size() const { return faces_.alive(); }
  std::size_t slots() const { return faces_.slots(); }
  bool is_alive(Index f) const { return faces_.is_alive(f); }
  const Triangle& face(Index f) const { return faces_.face(f); }
  std::span<const Index> faces_of(Index v) const { return faces_.of_vertex(v); }

  /// Calls visit(a, b), a < b, for each edge of the faces, in their order. `visit` changes none of them.
  template <typename Visit>
  void for_each_edge(const Visit& visit) const {
    for (Index f = 0; f < slots(); ++f) {
      const Triangle& t = face(f);
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

  /// What is proven of the distance to the input's skin.
  const SkinDistance& distance() const { return distance_; }

  /// The volume inside the faces.
  double volume(const WorkingMesh& mesh) const;

  /// The middle of a face that is in contact with another one now, if there is one. Time: linear in the faces
  /// where few meet.
  std::optional<Vec3> find_contact();

  /// Whether a change keeps two-sided distance and embedding. Remembers the proof for apply().
  BoundaryVerdict check(const WorkingMesh& mesh, const BoundaryChange& change);

  /// Carries out the change that was checked last; the caller does so in the mesh.
  void apply(const BoundaryChange& change);

 private:
  bool touches_others();
  void collect_near(const BoundingBox& box);
  void widen_grid();
  void fill_grid();

  SkinFaces faces_;
  SkinDistance distance_;
  std::size_t faces_in_grid_;
  FaceGrid grid_;
  FeatureLines lines_;
  PlannedChange plan_;
  std::vector<Index> near_;
};

/// How much a vertex is held: frozen ones stay like corners.
FeatureRank hold_on(const WorkingMesh& mesh, const GuardedBoundary& boundary, Index v);

}  // namespace palpate::simplify

// Sharp edges of the skin as curves that simplification keeps: which edges belong to one, which vertices
// stay, and whether a change leaves the curves within a distance of the input's.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/simplify/cover/line_cover.h"
#include "core/simplify/sizing/triangle_tree.h"
#include "core/simplify/tet_operations/working_mesh.h"

namespace palpate::simplify {

/// What a boundary vertex is to the feature lines.
enum class FeatureRank : std::uint8_t {
  kNone,    ///< on no line
  kOnLine,  ///< a line goes through: it may move along it
  kCorner   ///< an end, a meeting of three and more, or a sharp turn of a line: it stays
};

/// The feature edges of a skin, as they are now and as the input has them.
///
/// An edge of the input's skin is a feature edge if the outward normals of its two faces differ by more than
/// the angle (or if it has not two faces). A vertex with another number of feature edges than two is a
/// corner, and so is one where the direction of its line turns by more than the same angle.
class FeatureLines {
 public:
  /// No lines.
  FeatureLines() = default;

  /// Finds the lines of `faces`. `angle_deg` in (0, 180); `limit` as in LineCover.
  FeatureLines(const WorkingMesh& mesh, std::span<const Triangle> faces, double angle_deg, double limit);

  bool is_empty() const { return alive_ == 0; }
  std::size_t size() const { return alive_; }  ///< edges
  std::size_t corners() const;                 ///< vertices

  FeatureRank rank(Index v) const { return v < rank_.size() ? rank_[v] : FeatureRank::kNone; }
  bool is_line(Index a, Index b) const;

  /// Whether two faces with these normals (of any length) meet at a sharp edge.
  bool is_sharp(const Vec3& normal, const Vec3& other) const;

  /// Whether the lines at both ends of the feature edge (a, b) go on straight, to rounding.
  bool is_straight_at(const WorkingMesh& mesh, Index a, Index b) const;

  /// Changes the limit for what comes. It may only grow.
  void raise_limit(double limit);

  /// Takes over new numbers of the vertices: new_number[v] is that of v.
  void renumber(const std::vector<Index>& new_number, std::size_t vertices);

  /// Whether `gone` may become `survivor`, which comes to lie at `to`: the lines stay what they are as a
  /// graph (no edge twice, a ring keeps three), and their two-sided distance to the input's is at most the
  /// limit. Remembers the proof for collapse(). Requires: is_line(gone, survivor); rank(gone) is kOnLine.
  bool permits_collapse(const WorkingMesh& mesh, Index gone, Index survivor, const Vec3& to);

  /// Carries out the collapse that was asked for last.
  void collapse(Index gone, Index survivor);

 private:
  using LineEdge = std::array<Index, 2>;
  struct Proof {
    Index input = 0;
    std::vector<Index> covering;  ///< numbers of edges, as they are after the collapse
  };

  Index other_end(Index e, Index v) const { return edges_[e][edges_[e][0] == v ? 1 : 0]; }
  void find_edges(const WorkingMesh& mesh, std::span<const Triangle> faces);
  void find_corners(const WorkingMesh& mesh);
  void link(Index e);
  void unlink(Index e);
  bool would_fold(Index gone, Index survivor) const;
  void place_fresh(const WorkingMesh& mesh, Index gone, Index survivor, const Vec3& to);
  void list_candidates(const WorkingMesh& mesh, Index gone, Index survivor);
  bool input_stays_near();

  double cosine_ = -2.0;         ///< of the angle
  std::vector<LineEdge> edges_;  ///< a dead one has kNoIndex as its first vertex
  std::vector<std::vector<Index>> of_vertex_;
  std::vector<FeatureRank> rank_;
  std::size_t alive_ = 0;

  std::vector<SegmentEnds> input_;
  std::optional<TriangleTree> tree_;  ///< of the input's, as triangles (a, b, b)
  LineCover cover_{0.0};
  std::vector<std::vector<Index>> covering_;    // of each input edge: edges whose union is within the limit
  std::vector<std::vector<Index>> covered_by_;  // of each edge: input edges; may hold some of long ago

  // The collapse under examination.
  std::vector<Index> removed_;      // numbers of edges; the last is that between the two ends
  std::vector<SegmentEnds> fresh_;  // the i-th takes the number of the i-th removed one
  std::vector<Index> around_;
  std::vector<SegmentEnds> candidates_;
  std::vector<Index> used_;
  std::vector<Proof> proofs_;
};

}  // namespace palpate::simplify

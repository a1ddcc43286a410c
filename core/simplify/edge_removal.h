// Flips: an edge is replaced by triangles across its ring, or a face by an edge, where that is better.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/simplify/cone.h"
#include "core/simplify/working_mesh.h"

namespace palpate::simplify {

inline constexpr std::size_t kLargestRing = 7;

/// The tets around an inner edge (a, b), in order: tet i has the vertices a, b, ring[i], ring[i + 1] and is
/// positive as (a, b, ring[i], ring[i + 1]).
struct EdgeRing {
  Index a = kNoIndex;
  Index b = kNoIndex;
  std::size_t size = 0;
  std::array<Index, kLargestRing> ring{};
  std::array<Index, kLargestRing> tets{};
};

/// Finds the ring of edge (a, b). Returns false if it is on the boundary, longer than kLargestRing, or has a
/// kept tet.
bool find_edge_ring(const WorkingMesh& mesh, Index a, Index b, EdgeRing& ring);

/// How a flip is judged.
struct FlipRule {
  ScoreScale scale;
  double mean_gain = 0.0;         ///< gain that each tet more must bring, as counts are not free
  std::uint64_t fewest_tets = 0;  ///< no flip may leave fewer
  std::uint64_t most_tets = ~std::uint64_t{0};  ///< or more
};

/// Carries out flips.
class Flipper {
 public:
  Flipper(WorkingMesh& mesh, const FlipRule& rule) : mesh_(mesh), rule_(rule) {}

  /// Removes edge (a, b) if the best triangulation of its ring is better than the tets around it.
  bool try_remove_edge(Index a, Index b);
  /// Replaces the face of `tet` opposite to its corner by an edge, if that is better (2-3 flip).
  bool try_remove_face(Index tet, std::size_t corner);

  const std::vector<Index>& added() const { return added_; }

 private:
  double known_score(Index t);

  WorkingMesh& mesh_;
  const FlipRule& rule_;
  std::vector<Tet> fresh_;
  std::vector<Index> added_;
  Cone cone_;
  std::vector<double> scores_a_;
  std::vector<double> scores_b_;
};

/// The score of tet (a, b, c, d).
double score_tet(const ScoreScale& scale, const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

}  // namespace palpate::simplify

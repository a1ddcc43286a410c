// Flips of boundary edges under the guard of a GuardedBoundary.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/simplify/skin_guard/guarded_boundary.h"
#include "core/simplify/tet_operations/flips.h"
#include "core/simplify/tet_operations/score_rule.h"
#include "core/simplify/tet_operations/working_mesh.h"

namespace palpate::simplify {

/// The tets around a boundary edge (a, b), from one boundary face to the other: tet i has the vertices a, b,
/// fan[i], fan[i + 1] and is positive as (a, b, fan[i], fan[i + 1]). The faces (a, fan[0], b) and
/// (a, b, fan[size]) are on the boundary.
struct EdgeFan {
  static constexpr std::size_t kMostTets = 5;
  Index a = kNoIndex;
  Index b = kNoIndex;
  std::size_t size = 0;  ///< tets
  std::array<Index, kMostTets + 1> fan{};
  std::array<Index, kMostTets> tets{};
  std::array<Index, 2> faces{};  ///< numbers in the skin, of the first and of the last
};

/// What flips of boundary edges are for.
enum class FlipAim {
  kWorst,  ///< the worst tet around gets better
  kSum     ///< the sum of gains grows, as for a Flipper, a tet more being one of the usual score
};

/// Flips boundary edges where the tets around them get better.
///
/// The two faces at the edge (a, b) give way to those at the edge from fan[0] to fan[n], and the n tets to
/// two for each triangle of the best triangulation of the fan (one to a, one to b); a single tet is peeled
/// off.
class BoundaryFlipper {
 public:
  BoundaryFlipper(WorkingMesh& mesh, GuardedBoundary& boundary, const ScoreRule& scores, FlipAim aim)
      : mesh_(mesh), boundary_(boundary), scores_(scores), aim_(aim), may_fold_(aim == FlipAim::kWorst) {}

  /// Whether an edge of the skin may get sharper than a right angle that was not: for the worst tet it may.
  void set_may_fold(bool may) { may_fold_ = may; }

  /// Peeling takes a tet away, flips of fans of more than two add some: only within this range of counts.
  void set_range(std::uint64_t fewest, std::uint64_t most) {
    fewest_tets_ = fewest;
    most_tets_ = most;
  }

  /// One pass over all boundary edges with a tet of a score below `threshold`. Returns how many were flipped.
  std::uint64_t pass(double threshold);

  /// Flips edge (a, b) if it is no feature edge, the tets there get better by it, the skin's guard permits it
  /// and, where there are feature edges, no other becomes as sharp.
  bool try_flip(Index a, Index b, double threshold);

 private:
  bool find_fan(Index a, Index b, EdgeFan& fan) const;
  double worst_score(const EdgeFan& fan);
  bool raises_worst(const EdgeFan& fan, double worst);
  bool raises_sum(const EdgeFan& fan, double worst);
  void list_triangles(std::size_t i, std::size_t j);
  std::array<Tet, 2> pair_over(const EdgeFan& fan, std::size_t i, std::size_t j, std::size_t k) const;
  bool is_permitted(const EdgeFan& fan);
  bool makes_edge_sharp(const EdgeFan& fan) const;
  bool refuse(const EdgeFan& fan);
  void note_flip(const EdgeFan& fan);
  bool is_refused_still(Index f, std::size_t side) const;

  WorkingMesh& mesh_;
  GuardedBoundary& boundary_;
  const ScoreRule& scores_;
  FlipAim aim_;
  bool may_fold_;
  ScoreScale scale_;  ///< at the edge under examination
  std::uint64_t fewest_tets_ = 0;
  std::uint64_t most_tets_ = ~std::uint64_t{0};
  BoundaryChange change_;
  RingValues value_{};
  std::vector<RingTriangle> triangles_;  ///< of the fan, in the place of its tets
  std::vector<Tet> fresh_;
  std::vector<Index> added_;
  std::array<std::array<std::size_t, EdgeFan::kMostTets + 1>, EdgeFan::kMostTets + 1> apex_{};
  // Of a pass, by its clock, which a flip moves on: an edge is seen from both of its faces.
  std::uint64_t clock_ = 1;
  std::vector<std::array<std::uint64_t, 3>> refused_;  ///< at a face's sides: when last; 0: not
  std::vector<std::uint64_t> flipped_;                 ///< at a vertex: when last
};

}  // namespace palpate::simplify

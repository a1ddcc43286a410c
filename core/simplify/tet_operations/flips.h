// Flips: an edge gives way to triangles across its ring, or a face to an edge, where that is better.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/simplify/tet_operations/quality_floor.h"
#include "core/simplify/tet_operations/score_rule.h"
#include "core/simplify/tet_operations/star_quality.h"
#include "core/simplify/tet_operations/working_mesh.h"

namespace palpate::simplify {

/// The tets around an inner edge (a, b), in order: tet i has the vertices a, b, ring[i], ring[i + 1] and is
/// positive as (a, b, ring[i], ring[i + 1]).
struct EdgeRing {
  Index a = kNoIndex;
  Index b = kNoIndex;
  std::size_t size = 0;
  std::array<Index, kLargestRing> ring{};
  std::array<Index, kLargestRing> tets{};
};

/// Orders the `count` <= kLargestRing tets around edge (a, b) into a ring. Returns false if they do not
/// close, that is, if the edge is on the boundary, or if they are fewer than 3.
bool order_edge_ring(const WorkingMesh& mesh, Index a, Index b, const Index* tets, std::size_t count,
                     EdgeRing& ring);

/// Finds the ring of edge (a, b). Returns false if it is on the boundary, longer than kLargestRing, or has a
/// kept tet.
bool find_edge_ring(const WorkingMesh& mesh, Index a, Index b, EdgeRing& ring);

/// What a triangle is worth that may not be.
inline constexpr double kForbidden = -1e300;
/// value[i][k][j]: what the triangle of the ring's vertices i < k < j is worth.
using RingValues = std::array<std::array<std::array<double, kLargestRing>, kLargestRing>, kLargestRing>;
/// Places in the ring.
using RingTriangle = std::array<std::size_t, 3>;

/// The best way to fill a ring of `size` vertices with triangles, by dynamic programming over its arcs.
///
/// value[i][k][j], i < k < j, is what triangle (i, k, j) is worth, or kForbidden; the best sum is wanted.
/// Returns it, or kForbidden if there is no filling; `triangles` gets the size - 2 triangles.
/// Source: Klincsek, Ann. Discrete Math. 9 (1980); Shewchuk, "Two discrete optimization algorithms for the
/// topological improvement of tetrahedral meshes" (2002).
double best_ring_filling(const RingValues& value, std::size_t size, std::vector<RingTriangle>& triangles);

/// Whether a ring of `size` vertices can be filled with triangles of `allowed`, a bit a triangle in the order
/// of ring_triangles().
bool can_fill_ring(std::uint64_t allowed, std::size_t size);

/// When a flip is made.
struct FlipRule {
  double least_growth = 1e-6;                   ///< the sum of gains must grow by more
  double least_of_worst = 0.5;                  ///< no score may fall below this share of the worst before
  std::uint64_t fewest_tets = 0;                ///< no flip may leave fewer
  std::uint64_t most_tets = ~std::uint64_t{0};  ///< or more
  std::size_t largest_ring = kLargestRing;      ///< edges with more tets around them stay
};

/// Makes flips. Sums of gains are over the tets that change; a tet more counts as one of the usual score, so
/// that counts are not free. Every tet stays positive, exactly; kept tets and the boundary stay as they are.
class Flipper {
 public:
  /// Holds references to the mesh and the score rule.
  Flipper(WorkingMesh& mesh, const ScoreRule& scores, const FlipRule& rule)
      : mesh_(mesh), scores_(scores), rule_(rule) {}

  void set_rule(const FlipRule& rule) { rule_ = rule; }
  const FlipRule& rule() const { return rule_; }

  /// No flip leaves a tet below the floor; null: there is none.
  void set_floor(const QualityFloor* floor) { floor_ = floor; }

  /// Removes edge (a, b) if the best filling of its ring is better than the tets around it.
  bool try_remove_edge(Index a, Index b);

  /// Tries the edges of which `tet` is the lowest-scored tet (ties: the smallest slot), so that a pass over
  /// all tets tries each edge once. Returns whether one was removed; `tet` is dead then.
  bool try_edges_of(Index tet);

  /// Replaces the face of `tet` opposite to its corner by an edge (2-3 flip) if that is better.
  bool try_remove_face(Index tet, std::size_t corner);

  /// Splits edge (a, b) at its midpoint. The caller judges; see growth(). Returns the new vertex, or kNoIndex
  /// if the edge cannot be split or there would be too many tets.
  Index split_edge(Index a, Index b);

  /// Replaces `old` by the tets between a new vertex at `place` and `faces`, which bound them: (place, a, b,
  /// c) is to be positive. The caller judges; see growth(). Returns the new vertex, or kNoIndex if a tet
  /// would not be positive or there would be too many.
  Index insert_vertex(std::span<const Index> old, const Vec3& place, std::span<const Triangle> faces);

  /// Takes the last flip, split or insertion back. Requires that no other operation came since.
  void undo();

  /// The score of tet t, computed if it is not known.
  double known_score(Index t);

  /// Of the last flip, split or insertion: the tets before (as they were), the slots of those after, and by
  /// how much the sum of gains has grown.
  const std::vector<Tet>& removed() const { return removed_; }
  const std::vector<Index>& added() const { return added_; }
  double growth() const { return growth_; }

 private:
  struct Before {
    double sum = 0.0;
    double worst = 0.0;
  };
  Before measure_before(const Index* tets, std::size_t count);
  bool try_ring(const EdgeRing& ring);
  void take_ring(const EdgeRing& ring);
  bool can_be_filled(const EdgeRing& ring) const;
  bool is_all_positive(const std::vector<Tet>& tets) const;
  void measure_ring(const EdgeRing& ring, double least_score, RingValues& value);
  bool flip(const Index* old, std::size_t count);
  Index flip_with_vertex(std::span<const Index> old, Index vertex);

  WorkingMesh& mesh_;
  const ScoreRule& scores_;
  FlipRule rule_;
  const QualityFloor* floor_ = nullptr;
  StarQuality star_;
  RingValues value_{};
  std::vector<RingTriangle> triangles_;
  std::vector<float> scores_a_;
  std::vector<float> scores_b_;
  std::vector<Tet> fresh_;
  std::vector<float> fresh_scores_;
  std::vector<Tet> removed_;
  std::vector<Index> added_;
  double growth_ = 0.0;
  Index split_vertex_ = kNoIndex;
};

}  // namespace palpate::simplify

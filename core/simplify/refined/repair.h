// The worst tets, one after another, by whatever helps.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "core/simplify/refined/cavity.h"
#include "core/simplify/tet_operations/flips.h"
#include "core/simplify/tet_operations/smoothing.h"

namespace palpate::simplify {

/// What a repair may use; one switch an ingredient.
struct RepairTools {
  bool smoothing = true;
  bool edge_removal = true;
  bool face_removal = true;
  bool compound_moves = true;  ///< a flip that is good only once the vertices around it have moved
  bool edge_splits = true;     ///< a new vertex in the middle of an edge of a tet that nothing else helps
  bool insertions = true;      ///< a new vertex amid the tets around a very bad one, which give way
  bool never_worse = true;     ///< no repair leaves a tet worse than the worst that it found around
};

/// How often each was made.
struct RepairCounts {
  std::uint64_t moves = 0;
  std::uint64_t edges_removed = 0;
  std::uint64_t faces_removed = 0;
  std::uint64_t splits = 0;
  std::uint64_t insertions = 0;
};

/// How often a means was tried, and how often it helped.
struct RepairSuccess {
  std::uint64_t tries = 0;
  std::uint64_t helped = 0;

  /// Whether it is worth another try: it helped once in kTriesPerHelp, or has not had its chance yet.
  bool is_worth_it() const;
  /// Counts a try; returns whether it helped.
  bool note(bool has_helped);
};

/// Repairs tets, the lowest score first (ties: the smallest slot). Gains weigh the worst tets heavily here,
/// so that a mesh is worth about as much as its worst tets.
///
/// Where many tets are bad it is mostly the skin that is, and nothing inside mends it. Then (`set_manner`)
/// the worst weigh less, so that what cannot be mended does not cost what is around it; no repair leaves a
/// tet worse than the worst that it found there; no vertex is shifted for a flip; and a means that keeps
/// failing is given up.
class Repairer {
 public:
  /// Holds a reference to the mesh, copies of the rules.
  Repairer(WorkingMesh& mesh, const ScoreRule& scores, const FlipRule& rule, const RepairTools& tools);
  Repairer(const Repairer&) = delete;
  Repairer& operator=(const Repairer&) = delete;

  /// Chooses the manner by the share of the tets with a score below `threshold`: up to a tenth few are bad.
  void set_manner(double threshold);
  /// Whether many were bad then.
  bool are_many_bad() const { return many_are_bad_; }

  /// One round over the tets with a score below `threshold`, as they are at its beginning: for each that is
  /// still there the first that helps of edge removal, face removal and smoothing of its free vertices.
  /// Below `compound_threshold` also compound moves and, last, splits and insertions. What an earlier round
  /// has tried in vain on a tet, all but these, is not tried again while its score is the same. A round takes
  /// the worst fourth of all tets at most, with compound moves the worst in 32, or in 64 where many are bad.
  void round(double threshold, double compound_threshold, int steps);

  /// Changes how far the count may go.
  void set_rule(const FlipRule& rule);

  /// No repair leaves a tet below the floor; null: there is none. The floor has to outlive the repairs.
  void set_floor(const QualityFloor* floor);

  const RepairCounts& counts() const { return counts_; }

 private:
  void remember_more();
  bool is_strict() const { return many_are_bad_ || tools_.never_worse; }
  bool is_worth_it(const RepairSuccess& means) const { return !many_are_bad_ || means.is_worth_it(); }
  bool try_flips(Index t, const Tet& tet);
  bool try_moves(const Tet& tet, int steps);
  bool try_compound(const Tet& tet, double score, int steps);
  bool try_splits(const Tet& tet, double score, int steps);
  bool try_insertions(const Tet& tet, double score, int steps);
  double worst_around(double enough);
  void swap_places();
  void note_scores(std::vector<float>& scores) const;
  void put_scores(const std::vector<float>& scores);
  double worst_beside();
  bool is_above_floor() const;
  double sweep_around(int steps);
  bool keep_if_better(double score, int steps, bool by_sum);
  bool try_shifted_flips(const Tet& tet, double score, int steps);
  bool try_shift(const EdgeRing& ring, Index v, double score, int steps);

  WorkingMesh& mesh_;
  ScoreRule scores_;
  RepairTools tools_;
  bool many_are_bad_ = false;
  const QualityFloor* floor_ = nullptr;
  Smoother smoother_;
  Flipper flipper_;
  Flipper trial_;  ///< makes flips that may be bad, for a trial
  RepairCounts counts_;
  RepairSuccess compound_;
  RepairSuccess split_;
  RepairSuccess insertion_;
  Cavity cavity_;
  StarQuality star_;
  std::vector<std::pair<float, Index>> bad_;
  std::vector<float> given_up_at_;  ///< the score at which flips and moves of a tet helped nothing
  std::vector<float> hopeless_at_;  ///< the score at which compound moves helped nothing either
  std::vector<Index> vertices_;
  std::vector<Vec3> places_;
  std::vector<float> scores_before_;  ///< around vertices_, before they move
  std::vector<float> scores_after_;
  std::vector<Vec3> proposed_;
  VertexMarks marks_;
};

}  // namespace palpate::simplify

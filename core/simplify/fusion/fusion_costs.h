// What each fusion would cost, kept up to date while the mesh changes.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/simplify/fusion/fusion.h"
#include "core/simplify/fusion/fusion_options.h"
#include "core/simplify/quality/batch_quality.h"

namespace palpate::simplify {

/// Why a fusion is refused.
enum class Refusal : std::uint8_t { kNone, kFlip, kQuality };

/// Whether a candidate passes the checks, and if not, on which moved tet it failed.
struct Weighing {
  Refusal refusal = Refusal::kNone;
  Index witness = kNoIndex;
};

/// Qualities of all tets, and costs of the candidates that were weighed.
///
/// A fusion changes the tets that it moves or removes. Of a candidate nearby these are only a few of the tets
/// around, so its cost is brought up to date by taking their old terms out of its sum and putting the new
/// ones in; the grid of batch_quality.h makes that exact.
class FusionCosts {
 public:
  FusionCosts(const FusionMesh& mesh, const CheapestFirstOptions& options, double ideal_volume);

  /// Weighs candidate t from scratch: its plan and, if it passes, its cost.
  Weighing weigh(Index t);

  /// Whether the fusion of t fails on tet `witness`; it does not if that is none of its moved tets now.
  Refusal check_on(Index t, Index witness);

  /// The plan of the candidate weighed last.
  const FusionPlan& plan() const { return plan_; }
  /// Cost of a candidate that passed when last weighed or updated.
  double cost(Index t) const { return lost_[t] / static_cast<double>(removed_[t]); }

  /// A candidate whose cost a fusion changed, and whether it passes now.
  struct Affected {
    Index tet;
    Vec3 barycenter;
    Weighing weighing;
  };

  /// Carries out the plan of the candidate weighed last and brings all weighed candidates around up to date;
  /// is_weighed(t) tells which have a cost. Returns: those, each once; valid until the next call.
  template <typename IsWeighed>
  std::span<const Affected> fuse(FusionMesh& mesh, IsWeighed&& is_weighed) {
    mark_changes();
    for (const Index v : link_) {
      for (const Index t : mesh_.star(v)) {
        if (mark_[t] != Mark::kNone || !is_weighed(t)) continue;
        mark_[t] = Mark::kSeen;
        affected_.push_back({t, {}, {}});
      }
    }
    take_out_old_terms();
    apply_fusion(mesh, plan_);
    put_in_new_terms();
    return affected_;
  }

 private:
  enum class Mark : std::uint8_t { kNone, kMoved, kDead, kSeen };

  /// A changed tet that an affected candidate would move: `corner` of it goes to the candidate's barycenter.
  struct Term {
    Index affected;
    Index tet;
    std::uint8_t corner;
  };

  void measure_all();
  Refusal check(std::size_t in_batch, Index moved) const;
  void add_to_batch(Index tet, std::size_t corner, const Vec3& position);
  Weighing flush_star(std::size_t first_moved);
  void mark_changes();
  void find_terms(Index affected);
  void take_out_old_terms();
  void put_in_new_terms();

  const FusionMesh& mesh_;
  QualityMetric metric_;
  double ideal_volume_;
  double drop_;
  bool counts_removed_;
  double mean_quality_ = 0.0;
  std::vector<double> quality_;  ///< of each tet, on the grid
  std::vector<double> lost_;     ///< of each weighed candidate
  std::vector<std::uint32_t> removed_;
  FusionPlan plan_;
  std::vector<double> after_;  ///< qualities of plan_.moved
  TetBatch batch_;
  std::vector<Mark> mark_;
  std::vector<std::uint8_t> is_in_link_;  ///< of each vertex
  std::vector<Index> link_;               ///< vertices of changed tets that stay
  std::vector<Affected> affected_;
  std::vector<Term> terms_;
  std::vector<Term> shared_;  ///< changed tets that the candidate would remove; corner plays no part
};

}  // namespace palpate::simplify

#include "core/simplify/fusion/outcome.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "core/base/error.h"
#include "core/simplify/fusion/candidate_queue.h"
#include "core/simplify/fusion/outcome_costs.h"
#include "core/simplify/fusion/parking.h"

namespace palpate::simplify {
namespace {

class OutcomeRun {
 public:
  OutcomeRun(FusionMesh& mesh, std::vector<std::uint16_t> level, const std::vector<std::uint8_t>& is_kept,
             const OutcomeOptions& options, const SizingField& sizing, double ideal_volume)
      : mesh_(mesh),
        growth_(sizing, ideal_volume),
        options_(options.common),
        many_passes_(options.many_passes && options.common.skip_touched),
        level_(std::move(level)),
        state_(mesh.tets.size(), State::kIdle),
        is_weighed_(mesh.tets.size(), 0),
        parking_(mesh.tets.size()),
        costs_(mesh, options, ideal_volume),
        key_(mesh.tets.size(), 0.0) {
    for (Index t = 0; t < mesh.tets.size() && !is_kept.empty(); ++t) {
      if (has_flagged_vertex(mesh, t, is_kept)) state_[t] = State::kKept;
    }
  }

  void simplify(SimplifyReport& report) {
    report.stop = "limit";
    for (int grading = 0; grading <= growth_.passes(); ++grading) {
      growth_.start_pass(grading);
      if (!fuse_all(report)) break;
    }
    count_rejections(report.rejected);
  }

 private:
  static constexpr double kBeforeAll = -std::numeric_limits<double>::infinity();

  /// Fuses, in one pass or many, until no candidate is left. Returns false when a stop was reached first.
  bool fuse_all(SimplifyReport& report) {
    std::uint64_t fusions_before = 0;
    do {
      fusions_before = report.fusions;
      if (!run_pass(report)) return false;
    } while (many_passes_ && report.fusions > fusions_before);
    return true;
  }

  /// Fuses until no candidate is left. Returns false when a stop was reached first.
  bool run_pass(SimplifyReport& report) {
    const std::uint64_t target = target_tet_count(options_.stop, report.tets_in);
    bool is_filled = false;
    do {
      if (const char* stop = reached_stop(options_.stop, target, report.fusions, mesh_.alive)) {
        report.stop = stop;
        return false;
      }
      if (!std::exchange(is_filled, true)) fill_queue();
    } while (fuse_cheapest(report));
    return true;
  }

  bool is_allowed(Index t) const { return level_[t] != kNoLevel && level_[t] >= options_.last_level; }

  /// All tets that may be candidates in this pass, weighed.
  void fill_queue() {
    const auto may_be_candidate = [this](Index t) {
      if (state_[t] == State::kKept || is_parked(state_[t]) || !mesh_.is_alive(t)) return false;
      return is_allowed(t) && (state_[t] != State::kTouched || many_passes_);
    };
    std::size_t most = 0;
    for (Index t = 0; t < mesh_.tets.size(); ++t) most += static_cast<std::size_t>(may_be_candidate(t));
    queue_.clear();
    queue_.reserve(most);
    for (Index t = 0; t < mesh_.tets.size(); ++t) {
      if (!may_be_candidate(t)) continue;
      state_[t] = State::kIdle;
      if (!growth_.admits(corners_of(mesh_, t)) || !pass(t, costs_.weigh(t))) continue;
      key_[t] = costs_.cost(t);
      queue_.append({key_[t], mesh_.origin_of_tet(t), t});
    }
    queue_.heapify();
  }

  /// The key under which t stands in the queue; others of its entries are out of date.
  bool is_current(const Candidate& c) const {
    return state_[c.tet] == State::kWaiting && c.key == key_[c.tet];
  }

  void enqueue(Index t, double key) {
    key_[t] = key;
    queue_.push({key, mesh_.origin_of_tet(t), t});
  }

  /// Has t wait to be weighed, before anything else is fused.
  void wait_unweighed(Index t) {
    state_[t] = State::kWaiting;
    is_weighed_[t] = 0;
    enqueue(t, kBeforeAll);
  }

  /// Takes note of what weighing t found: it waits (true), or is parked on its witness.
  bool pass(Index t, const Weighing& weighing) {
    const bool passes = weighing.refusal == Refusal::kNone;
    is_weighed_[t] = static_cast<std::uint8_t>(passes);
    state_[t] = passes                               ? State::kWaiting
                : weighing.refusal == Refusal::kFlip ? State::kParkedFlip
                                                     : State::kParkedQuality;
    if (!passes) parking_.park(t, weighing.witness);
    return passes;
  }

  /// Fuses the cheapest candidate. Keys are never above the cost: one that is below it, because the cost has
  /// risen since, is set right when it comes up.
  bool fuse_cheapest(SimplifyReport& report) {
    const auto current = [this](const Candidate& c) { return is_current(c); };
    while (const Candidate* top = queue_.top(current)) {
      const Candidate c = *top;
      queue_.pop();
      const bool was_weighed = is_weighed_[c.tet] != 0;
      if (!was_weighed && !pass(c.tet, weigh_again(c.tet))) continue;
      if (costs_.cost(c.tet) != c.key) {
        enqueue(c.tet, costs_.cost(c.tet));
        continue;
      }
      require(costs_.weigh(c.tet).refusal == Refusal::kNone && costs_.cost(c.tet) == c.key,
              "fuse_cheapest: the cost was not up to date");
      fuse();
      ++report.fusions;
      return true;
    }
    return false;
  }

  /// Weighs t, beginning with the moved tet that it failed on last.
  Weighing weigh_again(Index t) {
    const Index witness = parking_.witness[t];
    if (witness != kNoIndex) {
      const Refusal refusal = costs_.check_on(t, witness);
      if (refusal != Refusal::kNone) return {refusal, witness};
    }
    return costs_.weigh(t);
  }

  void fuse() {
    const FusionPlan& plan = costs_.plan();
    for (const Index t : plan.dead) {
      if (is_parked(state_[t])) parking_.leave(t);
      state_[t] = State::kIdle;
    }
    for (const MovedTet& m : plan.moved) {
      if (is_parked(state_[m.tet])) parking_.leave(m.tet);
      if (state_[m.tet] != State::kKept) state_[m.tet] = State::kIdle;
    }
    const auto affected =
        costs_.fuse(mesh_, [this](Index t) { return state_[t] == State::kWaiting && is_weighed_[t] != 0; });
    for (const MovedTet& m : plan.moved) wake_parked_on(m.tet);
    for (const Index t : plan.dead) wake_parked_on(t);
    for (const MovedTet& m : plan.moved) renew(m.tet);
    for (const OutcomeCosts::Affected& a : affected) {
      if (pass(a.tet, a.weighing) && costs_.cost(a.tet) < key_[a.tet]) enqueue(a.tet, costs_.cost(a.tet));
    }
    queue_.tidy([this](const Candidate& c) { return is_current(c); });
  }

  /// A moved tet is another candidate than before, or none.
  void renew(Index t) {
    if (state_[t] == State::kKept || !is_allowed(t)) return;
    if (options_.skip_touched) {
      state_[t] = State::kTouched;
    } else if (growth_.admits(corners_of(mesh_, t))) {
      wait_unweighed(t);
    }
  }

  void wake_parked_on(Index witness) {
    Index t = std::exchange(parking_.first[witness], kNoIndex);
    while (t != kNoIndex) {
      const Index next = parking_.next[t];
      wait_unweighed(t);
      t = next;
    }
  }

  void count_rejections(Rejections& rejected) const {
    for (Index t = 0; t < mesh_.tets.size(); ++t) {
      if (!mesh_.is_alive(t)) continue;
      if (level_[t] == 0) {
        ++rejected.boundary;
      } else if (level_[t] < options_.last_level) {
        ++rejected.boundary_neighbour;
      } else if (state_[t] == State::kTouched) {
        ++rejected.touched;
      } else if (state_[t] == State::kKept) {
        ++rejected.kept;
      } else if (state_[t] == State::kParkedFlip) {
        ++rejected.flip;
      } else if (state_[t] == State::kParkedQuality) {
        ++rejected.quality;
      }
    }
  }

  FusionMesh& mesh_;
  GrowthBound growth_;
  const SimplifyOptions& options_;
  bool many_passes_;
  std::vector<std::uint16_t> level_;
  std::vector<State> state_;
  std::vector<std::uint8_t> is_weighed_;  ///< of those that wait: its cost is known and up to date
  Parking parking_;
  OutcomeCosts costs_;
  LazyHeap queue_;
  std::vector<double> key_;  ///< of those that wait: the key they stand under in the queue
};

void validate(const OutcomeOptions& options) {
  validate_options(options.common);
  if (!options.common.checks.flip || !options.common.checks.quality) {
    throw InputError("checks", 0, "all: the order by outcome makes both", "fewer");
  }
  if (options.common.ideal_volume != IdealVolume::kFixed) {
    throw InputError("ideal_volume", 0, "fixed: costs could not be compared over time", "updated");
  }
}

}  // namespace

SimplifyReport simplify_by_outcome(TetMesh& mesh, const OutcomeOptions& options) {
  validate(options);
  SimplifyReport report;
  report.vertices_in = mesh.points.size();
  report.tets_in = mesh.tets.size();

  const double ideal_volume = mean_tet_volume(mesh);
  const SizingField sizing(options.common.sizing, mesh);
  const std::vector<std::uint8_t> is_kept = build_kept_vertices(build_kept_tets(sizing, mesh), mesh);
  const std::vector<std::uint8_t> is_boundary = build_boundary_vertex_flags(mesh, options.common.threads);
  FusionMesh work = build_fusion_mesh(std::move(mesh), options.common.storage, options.common.threads);
  std::vector<std::uint16_t> level = build_levels(work, is_boundary, options.common.levels);
  report.level_sizes = count_levels(level);
  {
    OutcomeRun run(work, std::move(level), is_kept, options, sizing, ideal_volume);
    run.simplify(report);
  }
  mesh = extract_mesh(std::move(work));
  report.vertices_out = mesh.points.size();
  report.tets_out = mesh.tets.size();
  return report;
}

}  // namespace palpate::simplify

#include "core/simplify/fusion/cheapest_first.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "core/base/error.h"
#include "core/simplify/fusion/candidate_queue.h"
#include "core/simplify/fusion/fusion_costs.h"
#include "core/simplify/fusion/fusion_driver.h"
#include "core/simplify/fusion/parking.h"

namespace palpate::simplify {
namespace {

class CheapestFirstRun {
 public:
  CheapestFirstRun(FusionStart& start, const CheapestFirstOptions& options)
      : mesh_(start.mesh),
        growth_(start.sizing, start.ideal_volume),
        options_(options.common),
        many_passes_(options.many_passes && options.common.skip_touched),
        level_(start.level),
        state_(start.state),
        is_weighed_(mesh_.tets.size(), 0),
        parking_(mesh_.tets.size()),
        costs_(mesh_, options, start.ideal_volume),
        key_(mesh_.tets.size(), 0.0) {}

  void simplify(SimplifyReport& report) {
    report.stop = "limit";
    for (int grading = 0; grading <= growth_.passes(); ++grading) {
      growth_.start_pass(grading);
      if (!fuse_all(report)) break;
    }
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
    parking_.wake_witnesses_of(plan, [this](Index t) { wait_unweighed(t); });
    for (const MovedTet& m : plan.moved) renew(m.tet);
    for (const FusionCosts::Affected& a : affected) {
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

  FusionMesh& mesh_;
  GrowthBound growth_;
  const SimplifyOptions& options_;
  bool many_passes_;
  const std::vector<std::uint16_t>& level_;
  std::vector<State>& state_;
  std::vector<std::uint8_t> is_weighed_;  ///< of those that wait: its cost is known and up to date
  Parking parking_;
  FusionCosts costs_;
  LazyHeap queue_;
  std::vector<double> key_;  ///< of those that wait: the key they stand under in the queue
};

void validate(const CheapestFirstOptions& options) {
  validate_options(options.common);
  if (!options.common.checks.flip || !options.common.checks.quality) {
    throw InputError("checks", 0, "all: the order by outcome makes both", "fewer");
  }
  if (options.common.ideal_volume != IdealVolume::kFixed) {
    throw InputError("ideal_volume", 0, "fixed: costs could not be compared over time", "updated");
  }
}

}  // namespace

SimplifyReport simplify_cheapest_first(TetMesh& mesh, const CheapestFirstOptions& options) {
  validate(options);
  return simplify_by_fusions(mesh, options.common, [&](FusionStart& start, SimplifyReport& report) {
    CheapestFirstRun(start, options).simplify(report);
  });
}

}  // namespace palpate::simplify

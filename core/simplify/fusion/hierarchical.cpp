#include "core/simplify/fusion/hierarchical.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/mesh/orientation.h"
#include "core/simplify/fusion/candidate_queue.h"
#include "core/simplify/fusion/fusion_driver.h"
#include "core/simplify/fusion/parking.h"

namespace palpate::simplify {
namespace {

/// What a look at a candidate found.
struct Verdict {
  State state = State::kIdle;  ///< kIdle: it can be fused
  Index witness = kNoIndex;
};

class Run {
 public:
  Run(FusionStart& start, const SimplifyOptions& options)
      : mesh_(start.mesh),
        options_(options),
        growth_(start.sizing, start.ideal_volume),
        level_(start.level),
        state_(start.state),
        parking_(mesh_.tets.size()),
        qualities_(mesh_, options, start.ideal_volume),
        queue_(mesh_, qualities_, state_),
        total_volume_(start.ideal_volume * static_cast<double>(mesh_.tets.size())),
        drop_cubed_(options.drop * options.drop * options.drop) {}

  void simplify(SimplifyReport& report) {
    report.stop = "limit";
    sort_by_level(report.level_sizes);
    for (int pass = 0; pass <= growth_.passes(); ++pass) {
      growth_.start_pass(pass);
      if (!simplify_levels(report)) break;
    }
  }

  /// Fuses level by level. Returns whether all were gone through: false when a stop was reached.
  bool simplify_levels(SimplifyReport& report) {
    const std::uint64_t target = target_tet_count(options_.stop, mesh_.tets.size());
    int level = static_cast<int>(report.level_sizes.size());
    while (--level >= options_.last_level) {
      start_level(static_cast<std::uint16_t>(level));
      do {
        if (const char* stop = reached_stop(options_.stop, target, report.fusions, mesh_.alive)) {
          report.stop = stop;
          return false;
        }
      } while (fuse_worst(report));
      end_level();
    }
    return true;
  }

 private:
  /// The tets of each level from last_level on, in rows by level, each in storage order.
  void sort_by_level(const std::vector<std::uint64_t>& level_sizes) {
    const auto first = static_cast<std::size_t>(options_.last_level);
    level_begin_.assign(level_sizes.size() + 1, 0);
    for (std::size_t n = first; n < level_sizes.size(); ++n)
      level_begin_[n + 1] = level_begin_[n] + level_sizes[n];
    members_.resize(level_begin_.back());
    std::vector<std::size_t> next(level_begin_);
    for (Index t = 0; t < mesh_.tets.size(); ++t) {
      if (level_[t] != kNoLevel && level_[t] >= first) members_[next[level_[t]]++] = t;
    }
  }

  std::span<const Index> members_of_level() const {
    return {members_.data() + level_begin_[current_level_],
            members_.data() + level_begin_[current_level_ + 1U]};
  }

  void start_level(std::uint16_t level) {
    current_level_ = level;
    const std::span<const Index> members = members_of_level();
    for_ranges(members.size(), options_.threads, [&](std::size_t first, std::size_t last, std::size_t) {
      for (const Index t : members.subspan(first, last - first)) {
        if (!mesh_.is_alive(t) || state_[t] == State::kTouched || state_[t] == State::kKept) continue;
        if (!growth_.admits(corners_of(mesh_, t))) continue;
        state_[t] = State::kWaiting;
        qualities_.ensure(mesh_, t);
      }
    });
    queue_.fill(members);
  }

  /// The level is done with: its candidates leave their witnesses and keep the reason.
  void end_level() {
    for (const Index t : members_of_level()) {
      if (!is_parked(state_[t])) continue;
      parking_.leave(t);
      state_[t] = state_[t] == State::kParkedFlip ? State::kRefusedFlip : State::kRefusedQuality;
    }
    reconsider_.clear();
  }

  /// Fuses the worst candidate that passes the checks. Returns whether there was one.
  bool fuse_worst(SimplifyReport& report) {
    while (true) {
      reconsider_for_ideal_volume();
      const Index t = queue_.pop_worst();
      if (t == kNoIndex) return false;
      const Verdict verdict = examine(t);
      if (verdict.state == State::kIdle) {
        fuse();
        ++report.fusions;
        return true;
      }
      state_[t] = verdict.state;
      parking_.park(t, verdict.witness);
      if (verdict.state == State::kParkedQuality && qualities_.is_updated())
        plan_reconsideration(t, verdict.witness);
    }
  }

  /// Looks at a candidate: first at the moved tet that failed it last time, then at all, flips before
  /// qualities.
  Verdict examine(Index t) {
    const Index last_witness = parking_.witness[t];
    if (options_.checks.flip && last_witness != kNoIndex && mesh_.is_alive(last_witness) &&
        would_flip(t, last_witness)) {
      return {State::kParkedFlip, last_witness};
    }
    const bool flips = !walk_fusion(mesh_, t, plan_, [&](const MovedTet& m) {
      const auto p = moved_points(mesh_, plan_, m);
      plan_.figures.push_back({orientation(p[0], p[1], p[2], p[3]) > 0, 0.0, 0.0});
      return plan_.figures.back().is_positive || !options_.checks.flip;
    });
    if (flips) return {State::kParkedFlip, plan_.moved.back().tet};
    for (std::size_t i = 0; i < plan_.moved.size(); ++i) {
      if (plan_.figures[i].is_positive) {
        const auto p = moved_points(mesh_, plan_, plan_.moved[i]);
        plan_.figures[i] = measure_positive_tet(options_.metric, p[0], p[1], p[2], p[3]);
      }
      if (!options_.checks.quality) continue;
      qualities_.ensure(mesh_, plan_.moved[i].tet);
      if (qualities_.key(plan_.figures[i]) < drop_cubed_ * qualities_.key(plan_.moved[i].tet)) {
        return {State::kParkedQuality, plan_.moved[i].tet};
      }
    }
    return {};
  }

  /// Does fusing `t` flip `other`? False if `other` does not share exactly one vertex with it.
  bool would_flip(Index t, Index other) const {
    const Tet& center = mesh_.tets[t];
    const Tet& tet = mesh_.tets[other];
    int shared = 0;
    std::size_t corner = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      if (std::find(center.begin(), center.end(), tet[k]) == center.end()) continue;
      ++shared;
      corner = k;
    }
    if (shared != 1) return false;
    std::array<Vec3, 4> p{mesh_.points[tet[0]], mesh_.points[tet[1]], mesh_.points[tet[2]],
                          mesh_.points[tet[3]]};
    p[corner] = 0.25 * (mesh_.points[center[0]] + mesh_.points[center[1]] + mesh_.points[center[2]] +
                        mesh_.points[center[3]]);
    return orientation(p[0], p[1], p[2], p[3]) <= 0;
  }

  void fuse() {
    for (const Index t : plan_.dead) {
      if (is_parked(state_[t])) parking_.leave(t);
      state_[t] = State::kIdle;
    }
    apply_fusion(mesh_, plan_);
    if (qualities_.is_updated())
      qualities_.set_ideal_volume(total_volume_ / static_cast<double>(mesh_.alive));
    for (std::size_t i = 0; i < plan_.moved.size(); ++i) {
      const Index t = plan_.moved[i].tet;
      qualities_.set(t, plan_.figures[i]);
      if (is_parked(state_[t])) parking_.leave(t);
      if (state_[t] == State::kKept) continue;
      if (options_.skip_touched) {
        state_[t] = State::kTouched;
      } else if (level_[t] == current_level_) {
        const bool waits = growth_.admits(corners_of(mesh_, t));
        state_[t] = waits ? State::kWaiting : State::kIdle;
        if (waits) queue_.push(t);
      }
    }
    parking_.wake_witnesses_of(plan_, [this](Index t) {
      state_[t] = State::kWaiting;
      queue_.push(t);
    });
  }

  /// A growing ideal volume can heal a loss of quality though neither tet changes: where the moved tet is
  /// larger than the ideal volume and than it was, its key still grows. Notes the ideal volume at which it
  /// could pass, rounded down.
  void plan_reconsideration(Index t, Index witness) {
    const auto at = std::find_if(plan_.moved.begin(), plan_.moved.end(),
                                 [&](const MovedTet& m) { return m.tet == witness; });
    const TetFigures& after = plan_.figures[static_cast<std::size_t>(at - plan_.moved.begin())];
    const double volume_before = qualities_.volume(witness);
    if (after.shape <= 0.0 || after.volume <= volume_before || after.volume <= qualities_.ideal_volume())
      return;
    const double passes_at = drop_cubed_ * qualities_.shape(witness) * volume_before / after.shape;
    if (passes_at > after.volume * (1.0 + kRoundingMargin)) return;
    const double next = std::nextafter(qualities_.ideal_volume(), std::numeric_limits<double>::infinity());
    reconsider_.push({std::max(next, passes_at * (1.0 - kRoundingMargin)), mesh_.origin_of_tet(t), t});
  }

  void reconsider_for_ideal_volume() {
    const auto any = [](const Candidate&) { return true; };
    for (const Candidate* c = reconsider_.top(any); c != nullptr && c->key <= qualities_.ideal_volume();
         c = reconsider_.top(any)) {
      const Index t = c->tet;
      reconsider_.pop();
      if (!mesh_.is_alive(t) || state_[t] != State::kParkedQuality) continue;
      parking_.leave(t);
      state_[t] = State::kWaiting;
      queue_.push(t);
    }
  }

  /// Far above the rounding of the few operations it stands for; too large costs a second look, no more.
  static constexpr double kRoundingMargin = 1e-12;

  FusionMesh& mesh_;
  const SimplifyOptions& options_;
  GrowthBound growth_;
  const std::vector<std::uint16_t>& level_;
  std::vector<State>& state_;
  Parking parking_;
  Qualities qualities_;
  CandidateQueue queue_;
  LazyHeap reconsider_;
  FusionPlan plan_;
  std::vector<Index> members_;
  std::vector<std::size_t> level_begin_;
  std::uint16_t current_level_ = 0;
  double total_volume_;
  double drop_cubed_;
};

}  // namespace

SimplifyReport simplify_hierarchical(TetMesh& mesh, const SimplifyOptions& options) {
  validate_options(options);
  return simplify_by_fusions(mesh, options, [&](FusionStart& start, SimplifyReport& report) {
    Run(start, options).simplify(report);
  });
}

}  // namespace palpate::simplify

#include "core/simplify/outcome.h"

#include <algorithm>
#include <limits>
#include <span>
#include <utility>

#include "core/base/error.h"
#include "core/mesh/orientation.h"
#include "core/simplify/candidate_queue.h"
#include "core/simplify/parking.h"

namespace palpate::simplify {
namespace {

/// Rounds to a multiple of 2^-36: sums of up to 2^16 such numbers below 1 are exact in any order.
double round_quality(double q) {
  constexpr double kShift = 98304.0;  // 1.5 * 2^16
  return (q + kShift) - kShift;
}

class OutcomeRun {
 public:
  OutcomeRun(FusionMesh& mesh, std::vector<std::uint16_t> level, const OutcomeOptions& options,
             const SizingField& sizing, double ideal_volume)
      : mesh_(mesh),
        growth_(sizing, ideal_volume),
        options_(options.common),
        objective_(options.objective),
        many_passes_(options.many_passes && options.common.skip_touched),
        level_(std::move(level)),
        state_(mesh.tets.size(), State::kIdle),
        is_exact_(mesh.tets.size(), 0),
        key_(mesh.tets.size(), 0.0),
        quality_(mesh.tets.size()),
        parking_(mesh.tets.size()),
        ideal_volume_(ideal_volume) {}

  /// No tet that has one of these vertices (one flag each, by the input's numbers) is a candidate.
  void keep_vertices(const std::vector<std::uint8_t>& is_kept) {
    for (Index t = 0; t < mesh_.tets.size(); ++t) {
      if (has_flagged_vertex(mesh_, t, is_kept)) state_[t] = State::kKept;
    }
  }

  void simplify(SimplifyReport& report) {
    report.stop = "limit";
    measure_all();
    for (int grading = 0; grading <= growth_.passes(); ++grading) {
      growth_.start_pass(grading);
      if (!fuse_all(report)) break;
    }
    count_rejections(report.rejected);
  }

 private:
  static constexpr double kBeforeAll = -std::numeric_limits<double>::infinity();

  bool is_allowed(Index t) const { return level_[t] != kNoLevel && level_[t] >= options_.last_level; }

  /// Fuses until no candidate is left. Returns false when a stop was reached first.
  bool fuse_all(SimplifyReport& report) {
    const std::uint64_t target = target_tet_count(options_.stop, mesh_.tets.size());
    start_pass(many_passes_);
    std::uint64_t fusions_at_start = report.fusions;
    while (true) {
      if (const char* stop = reached_stop(options_.stop, target, report.fusions, mesh_.alive)) {
        report.stop = stop;
        return false;
      }
      if (fuse_cheapest()) {
        ++report.fusions;
      } else if (many_passes_ && report.fusions > fusions_at_start) {
        fusions_at_start = report.fusions;
        start_pass(true);
      } else {
        return true;
      }
    }
  }

  double quality_of(const TetFigures& figures) const {
    return round_quality(quality_factor(options_.metric, figures, ideal_volume_));
  }

  void measure_all() {
    double sum = 0.0;
    for (Index t = 0; t < mesh_.tets.size(); ++t) {
      const Tet& v = mesh_.tets[t];
      quality_[t] = quality_of(measure_positive_tet(options_.metric, mesh_.points[v[0]], mesh_.points[v[1]],
                                                    mesh_.points[v[2]], mesh_.points[v[3]]));
      sum += quality_[t];
    }
    mean_quality_ = round_quality(sum / static_cast<double>(mesh_.tets.size()));
  }

  void start_pass(bool clear_marks) {
    for (Index t = 0; t < mesh_.tets.size(); ++t) {
      if (!mesh_.is_alive(t) || !is_allowed(t) || is_parked(state_[t]) || state_[t] == State::kKept) continue;
      if ((clear_marks || state_[t] != State::kTouched) && growth_.admits(corners_of(mesh_, t)))
        make_waiting(t);
    }
  }

  /// Has t weighed before anything else is fused.
  void make_waiting(Index t) { wait(t, kBeforeAll, false); }

  void wait(Index t, double key, bool is_exact) {
    state_[t] = State::kWaiting;
    is_exact_[t] = static_cast<std::uint8_t>(is_exact);
    key_[t] = key;
    queue_.push({key, mesh_.origin_of_tet(t), t});
  }

  bool fuse_cheapest() {
    const auto is_current = [this](const Candidate& c) {
      return state_[c.tet] == State::kWaiting && c.key == key_[c.tet];
    };
    while (const Candidate* top = queue_.top(is_current)) {
      const Index t = top->tet;
      const bool is_exact = is_exact_[t] != 0;
      queue_.pop();
      const Look look = examine(t);
      if (look.state != State::kIdle) {
        state_[t] = look.state;
        parking_.park(t, look.witness);
      } else if (is_exact) {
        fuse();
        return true;
      } else {
        wait(t, look.cost, true);
      }
    }
    return false;
  }

  struct Look {
    State state = State::kIdle;  ///< kIdle: it can be fused
    Index witness = kNoIndex;
    double cost = 0.0;
  };

  Look examine(Index t) {
    const bool flips = !walk_fusion(mesh_, t, plan_, [&](const MovedTet& m) {
      const auto p = moved_points(mesh_, plan_, m);
      return orientation(p[0], p[1], p[2], p[3]) > 0;
    });
    if (flips) return {State::kParkedFlip, plan_.moved.back().tet, 0.0};
    after_.clear();
    double lost = 0.0;
    for (const MovedTet& m : plan_.moved) {
      const auto p = moved_points(mesh_, plan_, m);
      const double after = quality_of(measure_positive_tet(options_.metric, p[0], p[1], p[2], p[3]));
      if (after < options_.drop * quality_[m.tet]) return {State::kParkedQuality, m.tet, 0.0};
      lost += quality_[m.tet] - after;
      after_.push_back(after);
    }
    if (objective_ == OutcomeObjective::kTotalLoss) {
      for (const Index d : plan_.dead) lost += quality_[d] - mean_quality_;
    }
    return {State::kIdle, kNoIndex, lost / static_cast<double>(plan_.dead.size())};
  }

  void fuse() {
    for (const Index t : plan_.dead) {
      if (is_parked(state_[t])) parking_.leave(t);
      state_[t] = State::kIdle;
    }
    apply_fusion(mesh_, plan_);
    for (std::size_t i = 0; i < plan_.moved.size(); ++i) {
      const Index t = plan_.moved[i].tet;
      quality_[t] = after_[i];
      if (is_parked(state_[t])) parking_.leave(t);
      if (state_[t] == State::kKept) continue;
      state_[t] = options_.skip_touched && is_allowed(t) ? State::kTouched : State::kIdle;
      if (!options_.skip_touched && is_allowed(t) && growth_.admits(corners_of(mesh_, t))) make_waiting(t);
    }
    for (const MovedTet& m : plan_.moved) wake_parked_on(m.tet);
    for (const Index t : plan_.dead) wake_parked_on(t);
    for (const MovedTet& m : plan_.moved) {
      for (const Index v : mesh_.tets[m.tet]) {
        for (const Index t : mesh_.star(v)) {
          if (state_[t] == State::kWaiting && is_exact_[t] != 0) make_waiting(t);
        }
      }
    }
  }

  void wake_parked_on(Index witness) {
    Index t = std::exchange(parking_.first[witness], kNoIndex);
    while (t != kNoIndex) {
      const Index next = parking_.next[t];
      make_waiting(t);
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
  OutcomeObjective objective_;
  bool many_passes_;
  std::vector<std::uint16_t> level_;
  std::vector<State> state_;
  std::vector<std::uint8_t> is_exact_;  ///< key_ is the cost itself; otherwise a bound below it
  std::vector<double> key_;
  std::vector<double> quality_;
  Parking parking_;
  LazyHeap queue_;
  FusionPlan plan_;
  std::vector<double> after_;  ///< qualities of plan_.moved
  double ideal_volume_;
  double mean_quality_ = 0.0;
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
  const std::vector<std::uint8_t> is_boundary = build_boundary_vertex_flags(mesh);
  FusionMesh work = build_fusion_mesh(std::move(mesh), options.common.storage);
  std::vector<std::uint16_t> level = build_levels(work, is_boundary, options.common.levels);
  report.level_sizes = count_levels(level);
  {
    OutcomeRun run(work, std::move(level), options, sizing, ideal_volume);
    if (!is_kept.empty()) run.keep_vertices(is_kept);
    run.simplify(report);
  }
  mesh = extract_mesh(std::move(work));
  report.vertices_out = mesh.points.size();
  report.tets_out = mesh.tets.size();
  return report;
}

}  // namespace palpate::simplify

#include "core/dynamics/time_loop/motion_outcome.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "core/base/enum_names.h"
#include "core/base/error.h"
#include "core/mesh/geometry.h"

namespace palpate::dynamics {
namespace {

constexpr EnumNames<WatchedOutcome, 8> kNames{"a watched motion's outcome",
                                              {"steady", "oscillating", "energy_growing", "diverged",
                                               "inverted", "non_finite", "too_slow", "growing_slowly"}};
constexpr double kGrowth = 1.1;
constexpr double kSteady = 1e-6;
constexpr double kVisible = 1e-3;
constexpr std::uint64_t kRows = 40;
constexpr double kMostSpeed = 1e140;  // m/s; beyond, energies are no numbers any more

void check(const WatchOptions& options) {
  if (!(options.step_s > 0.0) || !std::isfinite(options.step_s))
    throw InputError("step", 0, "a finite number of seconds above zero", std::to_string(options.step_s));
  if (options.steps == 0) throw InputError("steps", 0, "at least one", "0");
  if (options.samples < 8) throw InputError("samples", 0, "at least 8", std::to_string(options.samples));
  if (!(options.escape_ratio > 0.0))
    throw InputError("escape ratio", 0, "a number above zero", std::to_string(options.escape_ratio));
  if (!(options.energy_factor >= 0.0))
    throw InputError("energy factor", 0, "a number of at least 0", std::to_string(options.energy_factor));
}

double size_of(const MotionModel& model) {
  return longest_side(bounding_box(model.elastic.rest));
}

/// The kinetic energy of a motion that rounding alone explains: a body whose springs are stretched by it, or
/// whose strain energies are swollen by it, 3 (lambda + 2 mu) V. Springs of E hold 3 E V.
double rounding_energy(const MotionModel& model, double rounding) {
  double energy = 0.0;
  const SpringNetwork& net = model.elastic.springs;
  for (std::size_t s = 0; s < net.springs.size(); ++s)
    energy += 0.5 * net.stiffness_n_per_m[s] * net.rest_length_m[s] * net.rest_length_m[s];
  for (const StrainTerm& term : model.elastic.strain_terms) {
    for (const double volume : term.op.volume_m3)
      energy += 3.0 * volume * (std::abs(term.moduli.lambda_pa) + 2.0 * std::abs(term.moduli.mu_pa));
  }
  return rounding * rounding * energy;
}

/// Whether displacement and velocity of a vertex are finite, with energies that are.
bool is_number(const MotionState& state, std::size_t v) {
  const Vec3& speed = state.velocity_m_s[v];
  return is_finite(state.displacement_m[v]) && is_finite(speed) && length(speed) < kMostSpeed;
}

/// The greatest values of one quarter of a run.
struct Quarter {
  double energy_j = -std::numeric_limits<double>::max();
  double kinetic_j = 0.0;
};

/// What one look at the body saw.
struct Sample {
  std::uint64_t step = 0;
  double energy_j = 0.0;
  double kinetic_j = 0.0;
  Index fastest = kNoIndex;
};

double number_or_nan(double value) {
  return std::isfinite(value) ? value : std::numeric_limits<double>::quiet_NaN();
}

/// Gathers samples into rows: one of the start, one a fortieth of the steps, one of the end.
class RowKeeper {
 public:
  RowKeeper(BodyStepper& stepper, std::uint64_t steps) : stepper_(stepper), steps_(steps) {}

  void add(std::uint64_t step, const MotionEnergy& energy, std::size_t inverted, std::uint64_t unsolved,
           std::vector<WatchedRow>& rows) {
    const std::uint64_t part = std::min(kRows - 1, kRows * step / steps_);
    const bool is_same_part = rows.size() > 1 && part == part_;
    if (!is_same_part) start_row(rows);
    part_ = part;
    WatchedRow& row = rows.back();
    row.step = step;
    row.energy = {number_or_nan(energy.kinetic_j), number_or_nan(energy.elastic_j),
                  number_or_nan(energy.load_j)};
    row.inverted = inverted;
    row.unsolved = unsolved;
    row.farthest_m = 0.0;
    row.is_finite = true;
    const MotionState& state = stepper_.state();
    for (std::size_t v = 0; v < state.displacement_m.size(); ++v) {
      row.is_finite = row.is_finite && is_number(state, v);
      row.farthest_m = std::max(row.farthest_m, length(state.displacement_m[v]));
    }
    if (!row.is_finite) row.farthest_m = std::numeric_limits<double>::quiet_NaN();
    // std::fmax and fmin leave out what is no number.
    row.most_kinetic_j = std::fmax(row.most_kinetic_j, row.energy.kinetic_j);
    row.most_total_j = std::fmax(row.most_total_j, number_or_nan(energy.total_j()));
    row.least_total_j = std::fmin(row.least_total_j, number_or_nan(energy.total_j()));
  }

 private:
  static void start_row(std::vector<WatchedRow>& rows) {
    WatchedRow row;
    row.most_kinetic_j = row.most_total_j = row.least_total_j = std::numeric_limits<double>::quiet_NaN();
    rows.push_back(row);
  }

  BodyStepper& stepper_;
  std::uint64_t steps_;
  std::uint64_t part_ = 0;
};

class Watch {
 public:
  Watch(BodyStepper& stepper, const WatchOptions& options)
      : stepper_(stepper),
        options_(options),
        bound_(options.escape_ratio * size_of(stepper.model())),
        keeper_(stepper, options.steps) {}

  WatchedRun run(const MotionState& start) {
    stepper_.set_state(start);
    run_.energy_least_j = std::numeric_limits<double>::max();
    run_.energy_most_j = -std::numeric_limits<double>::max();
    const std::uint64_t stride = std::max<std::uint64_t>(1, options_.steps / options_.samples);
    // A run of many steps is looked at in pieces, and the last piece is taken again step by step.
    const std::uint64_t piece = std::clamp<std::uint64_t>(options_.steps / 100'000, 1, stride);
    bool goes_on = is_good(0) && sample(0);
    while (goes_on && run_.steps < options_.steps) {
      const std::uint64_t count =
          std::min({piece, stride - run_.steps % stride, options_.steps - run_.steps});
      if (count > 1) before_ = stepper_.state();
      const std::uint64_t unsolved = count_unsolved();
      stepper_.advance(options_.step_s, count);
      if (count > 1 && find_bad(stepper_.state()) != kNoIndex) {
        stepper_.set_state(before_);  // which counts from nothing again
        unsolved_before_ = unsolved;
        goes_on = repeat_singly(count);
      } else {
        run_.steps += count;
        goes_on = is_good(run_.steps);
      }
      const bool is_due = run_.steps % stride == 0 || run_.steps == options_.steps;
      goes_on = goes_on && (!is_due || sample(run_.steps));
    }
    if (goes_on) classify();
    run_.steps_unsolved = count_unsolved();
    return run_;
  }

 private:
  std::uint64_t count_unsolved() const { return unsolved_before_ + stepper_.steps_unsolved(); }

  bool repeat_singly(std::uint64_t count) {
    for (std::uint64_t k = 0; k < count; ++k) {
      stepper_.advance(options_.step_s, 1);
      ++run_.steps;
      if (!is_good(run_.steps)) return false;
    }
    return true;
  }

  /// The first vertex that is no number, or else the first that has escaped.
  Index find_bad(const MotionState& state) const {
    Index escaped = kNoIndex;
    for (std::size_t v = 0; v < state.displacement_m.size(); ++v) {
      if (!is_number(state, v)) return static_cast<Index>(v);
      if (escaped == kNoIndex && !(length(state.displacement_m[v]) <= bound_))
        escaped = static_cast<Index>(v);
    }
    return escaped;
  }

  void end_at(WatchedOutcome outcome, std::uint64_t step, Index vertex) {
    run_.outcome = outcome;
    run_.vertex = vertex;
    run_.time_s = static_cast<double>(step) * options_.step_s;
  }

  bool is_good(std::uint64_t step) {
    const MotionState& state = stepper_.state();
    const Index bad = find_bad(state);
    if (bad == kNoIndex) return true;
    end_at(is_number(state, bad) ? WatchedOutcome::kDiverged : WatchedOutcome::kNonFinite, step, bad);
    if (options_.keeps_rows)
      keeper_.add(step, measure_energy(stepper_.model(), state),
                  count_volume(stepper_.model(), state).inverted, count_unsolved(), run_.rows);
    return false;
  }

  /// Looks at energies and tets; false ends the run.
  bool sample(std::uint64_t step) {
    const MotionModel& model = stepper_.model();
    const MotionState& state = stepper_.state();
    const MotionEnergy energy = measure_energy(model, state);
    const VolumeCount tets = count_volume(model, state);
    if (options_.keeps_rows) keeper_.add(step, energy, tets.inverted, count_unsolved(), run_.rows);
    run_.inverted_end = tets.inverted;
    if (step == 0) run_.inverted_start = tets.inverted;
    if (tets.inverted > 0 && first_inverted_ == kNoIndex) {
      first_inverted_ = model.tets[tets.first_inverted][0];
      inverted_s_ = static_cast<double>(step) * options_.step_s;
    }
    const std::size_t quarter = std::min<std::uint64_t>(3, 4 * step / options_.steps);
    quarters_.at(quarter).kinetic_j = std::max(quarters_.at(quarter).kinetic_j, energy.kinetic_j);
    // An energy law without an energy for inverted tets says infinity: such a sample is left out.
    const double total = energy.total_j();
    if (std::isfinite(total)) {
      if (step == 0) {
        run_.energy_start_j = total;
        own_energy_start_j_ = energy.kinetic_j + energy.elastic_j;
      }
      quarters_.at(quarter).energy_j = std::max(quarters_.at(quarter).energy_j, total);
      run_.energy_least_j = std::min(run_.energy_least_j, total);
      run_.energy_most_j = std::max(run_.energy_most_j, total);
      samples_.push_back({step, total, energy.kinetic_j, find_fastest(state)});
    }
    if (options_.give_up && options_.give_up()) {
      end_at(WatchedOutcome::kTooSlow, step, kNoIndex);
      return false;
    }
    return true;
  }

  /// What the start had to give: over the least of the run, or as motion and strain.
  double had_at_start() const {
    return std::max(run_.energy_start_j - run_.energy_least_j, own_energy_start_j_);
  }

  /// The greatest energies of the last quarter against those of the others.
  bool is_growing() const {
    double energy = 0.0;
    double kinetic = 0.0;
    for (std::size_t q = 0; q < 3; ++q) {
      energy = std::max(energy, quarters_.at(q).energy_j - run_.energy_least_j);
      kinetic = std::max(kinetic, quarters_.at(q).kinetic_j);
    }
    const double seen = std::max(had_at_start(), run_.kinetic_most_j);
    return quarters_[3].energy_j - run_.energy_least_j > kGrowth * energy &&
           quarters_[3].energy_j - run_.energy_start_j > kVisible * seen &&
           quarters_[3].kinetic_j > kGrowth * kinetic;
  }

  /// The first look that saw more than `energy_factor` times the start's energy; none: nullptr.
  const Sample* find_excess(double noise) const {
    if (options_.energy_factor == 0.0) return nullptr;
    const double had = had_at_start();
    const auto found = std::find_if(samples_.begin(), samples_.end(), [&](const Sample& sample) {
      return sample.energy_j - run_.energy_least_j > options_.energy_factor * had + noise &&
             sample.kinetic_j > noise;
    });
    return found == samples_.end() ? nullptr : &*found;
  }

  Index find_fastest(const MotionState& state) const {
    Index fastest = kNoIndex;
    double most = 0.0;
    for (std::size_t v = 0; v < state.velocity_m_s.size(); ++v) {
      const double energy = stepper_.model().mass_kg[v] * length_sq(state.velocity_m_s[v]);
      if (energy > most) {
        most = energy;
        fastest = static_cast<Index>(v);
      }
    }
    return fastest;
  }

  void classify() {
    const MotionState& state = stepper_.state();
    for (const Quarter& quarter : quarters_)
      run_.kinetic_most_j = std::max(run_.kinetic_most_j, quarter.kinetic_j);
    run_.kinetic_end_j = quarters_[3].kinetic_j;
    for (const Vec3& u : state.displacement_m) run_.drift_m = std::max(run_.drift_m, length(u));
    if (run_.energy_most_j < run_.energy_least_j) run_.energy_most_j = run_.energy_least_j = 0.0;
    const double noise = rounding_energy(stepper_.model(), stepper_.rounding());
    const bool is_still = run_.kinetic_end_j <= std::max(kSteady * run_.kinetic_most_j, noise);
    if (const Sample* excess = find_excess(noise)) {
      end_at(WatchedOutcome::kEnergyGrowing, excess->step, excess->fastest);
    } else if (!is_still && is_growing()) {
      end_at(WatchedOutcome::kEnergyGrowing, run_.steps, find_fastest(state));
    } else if (run_.inverted_end > 0) {
      end_at(WatchedOutcome::kInverted, 0, first_inverted_);
      run_.time_s = inverted_s_;
    } else if (options_.is_known_to_grow) {
      end_at(WatchedOutcome::kGrowingSlowly, run_.steps, kNoIndex);
    } else {
      end_at(is_still ? WatchedOutcome::kSteady : WatchedOutcome::kOscillating, run_.steps, kNoIndex);
    }
  }

  BodyStepper& stepper_;
  const WatchOptions& options_;
  double bound_;
  RowKeeper keeper_;
  WatchedRun run_;
  MotionState before_;
  std::uint64_t unsolved_before_ = 0;  ///< steps that the stepper no longer counts
  std::array<Quarter, 4> quarters_;
  std::vector<Sample> samples_;
  double own_energy_start_j_ = 0.0;
  Index first_inverted_ = kNoIndex;
  double inverted_s_ = 0.0;
};

}  // namespace

const char* watched_outcome_name(WatchedOutcome outcome) {
  return kNames.of(outcome);
}

bool is_unstable(WatchedOutcome outcome) {
  return outcome == WatchedOutcome::kEnergyGrowing || outcome == WatchedOutcome::kDiverged ||
         outcome == WatchedOutcome::kNonFinite || outcome == WatchedOutcome::kGrowingSlowly;
}

WatchedRun watch_motion(BodyStepper& stepper, const MotionState& start, const WatchOptions& options) {
  check(options);
  return Watch(stepper, options).run(start);
}

}  // namespace palpate::dynamics

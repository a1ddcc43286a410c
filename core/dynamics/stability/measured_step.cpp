#include "core/dynamics/stability/measured_step.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/dynamics/linear_algebra/vertex_field.h"
#include "core/dynamics/time_loop/motion_outcome.h"

namespace palpate::dynamics {
namespace {

constexpr std::uint64_t kFirstStretch = 512;
constexpr double kFast = 1000.0;
constexpr double kSlow = 1.02;
constexpr double kGone = 1e-24;  // of the greatest kinetic energy: the motion has died out
constexpr double kHuge = 1e200;  // J

void check_positive(const char* what, double value) {
  if (!(value > 0.0) || !std::isfinite(value))
    throw InputError(what, 0, "a finite number above zero", std::to_string(value));
}

std::vector<Vec3> make_random_field(std::size_t vertices, double size, SplitMix64& random) {
  std::vector<Vec3> field(vertices);
  const auto next = [&] { return size * (2.0 * random.uniform() - 1.0); };
  for (Vec3& each : field) each = {next(), next(), next()};
  return field;
}

/// Tries steps about rest.
class Trials {
 public:
  Trials(BodyStepper& stepper, const MeasureStepOptions& options)
      : stepper_(stepper), options_(options), held_(stepper.model().elastic.rest.size()) {
    for (const HeldComponent& held : find_held(stepper.model()))
      held_[held.vertex] = static_cast<std::uint8_t>(held_[held.vertex] | (1U << held.axis));
  }

  bool grows(double step_s, MeasuredTrial& trial) {
    const MotionState start = make_start(step_s);
    const MotionEnergy energy = measure_energy(stepper_.model(), start);
    trial.start_j = energy.kinetic_j + energy.elastic_j;
    const double far = options_.growth_factor * trial.start_j;
    stepper_.set_state(start);
    greatest_ = peak_ = 0.0;
    std::uint64_t done = 0;
    const auto run_next = [&](std::uint64_t count) {
      stretch_peak_ = 0.0;
      const double mean = run_stretch(step_s, count, done);
      const std::uint64_t before = trial.stretches.empty() ? 0 : trial.stretches.back().until;
      trial.stretches.push_back({before + count, mean, stretch_peak_});
      return mean;
    };
    double before = run_next(kFirstStretch / 2);
    double now = run_next(kFirstStretch / 2);
    double last_ratio = 1.0;
    for (;;) {
      const bool is_slow_counted = options_.counts_slow_growth;
      const bool is_over = !(now < kHuge) || peak_ > far || (is_slow_counted && now > kFast * before);
      const bool is_gone = now <= kGone * greatest_;
      const bool is_slow = !is_slow_counted || now <= kSlow * before;
      if (is_over || is_gone || done >= options_.horizon_most ||
          (is_slow && done >= options_.horizon_least)) {
        trial.steps = done;
        return is_over || (!is_gone && !is_slow && now >= last_ratio * before);
      }
      last_ratio = std::max(kSlow, now / before);
      before = now;
      now = run_next(done);
    }
  }

 private:
  MotionState make_start(double step_s) const {
    SplitMix64 random(options_.seed);
    MotionState start = start_at_rest(stepper_.model());
    const std::size_t n = held_.size();
    std::vector<Vec3> u = make_random_field(n, options_.amplitude_m, random);
    std::vector<Vec3> v = make_random_field(n, options_.amplitude_m / step_s, random);
    clear_held(held_, u);
    clear_held(held_, v);
    add_scaled(start.displacement_m, 1.0, u);
    add_scaled(start.velocity_m_s, 1.0, v);
    return start;
  }

  /// The mean kinetic energy over some steps; infinity where it is no number.
  double run_stretch(double step_s, std::uint64_t count, std::uint64_t& done) {
    double sum = 0.0;
    const std::uint64_t end = done + count;
    while (done < end) {
      stepper_.advance(step_s, 1);
      ++done;
      double kinetic = 0.0;
      const MotionState& state = stepper_.state();
      for (std::size_t v = 0; v < held_.size(); ++v)
        kinetic += 0.5 * stepper_.model().mass_kg[v] * length_sq(state.velocity_m_s[v]);
      if (!(kinetic < kHuge)) {
        stretch_peak_ = std::numeric_limits<double>::infinity();
        return stretch_peak_;
      }
      sum += kinetic;
      stretch_peak_ = std::max(stretch_peak_, kinetic);
    }
    peak_ = std::max(peak_, stretch_peak_);
    const double mean = sum / static_cast<double>(count);
    greatest_ = std::max(greatest_, mean);
    return mean;
  }

  BodyStepper& stepper_;
  const MeasureStepOptions& options_;
  std::vector<std::uint8_t> held_;
  double greatest_ = 0.0;      ///< mean kinetic energy of a stretch
  double peak_ = 0.0;          ///< kinetic energy of a step
  double stretch_peak_ = 0.0;  ///< of the last stretch
};

/// Multiplies or divides the first step by `stride` until it is bracketed, then halves the bracket.
MeasuredStep bisect(double first, double stride, int most_strides, double tolerance,
                    const std::function<bool(double, MeasuredTrial&)>& grows) {
  MeasuredStep out;
  out.unstable_s = std::numeric_limits<double>::infinity();
  const auto attempt = [&](double step) {
    ++out.trials;
    MeasuredTrial trial;
    const bool is_unstable = grows(step, trial);
    out.steps += trial.steps;
    (is_unstable ? out.unstable_s : out.stable_s) = step;
    (is_unstable ? out.unstable : out.stable) = std::move(trial);
    return is_unstable;
  };
  double step = first;
  const bool first_grows = attempt(step);
  for (int k = 0; k < most_strides && !out.is_found(); ++k) {
    step = first_grows ? step / stride : step * stride;
    if (!(step > 0.0) || !std::isfinite(step)) break;
    attempt(step);
  }
  while (out.is_found() && out.unstable_s > (1.0 + tolerance) * out.stable_s) attempt(out.step_s());
  return out;
}

}  // namespace

bool MeasuredStep::is_found() const {
  return stable_s > 0.0 && std::isfinite(unstable_s);
}

double MeasuredStep::step_s() const {
  require(is_found(), "a bracket of two steps");
  return std::sqrt(stable_s) * std::sqrt(unstable_s);
}

MotionModel linearise(MotionModel model) {
  if (model.elastic.volume_force)
    throw InputError("model", 0, "springs and strain terms, which have a linear form", "a volume force");
  model.elastic.springs_are_linear = true;
  for (StrainTerm& term : model.elastic.strain_terms) term.law = StrainLaw::kLinear;
  return model;
}

MeasuredStep measure_stable_step(BodyStepper& stepper, const MeasureStepOptions& options) {
  check_positive("first step", options.first_step_s);
  check_positive("amplitude", options.amplitude_m);
  check_positive("tolerance", options.tolerance);
  check_positive("growth factor", options.growth_factor);
  if (!(options.stride > 1.0) || !std::isfinite(options.stride))
    throw InputError("stride", 0, "a finite number above 1", std::to_string(options.stride));
  if (options.horizon_least < kFirstStretch || options.horizon_most < options.horizon_least)
    throw InputError("horizon", 0, "at least 512 steps, and at most no fewer",
                     std::to_string(options.horizon_least) + " and " + std::to_string(options.horizon_most));
  Trials trials(stepper, options);
  return bisect(options.first_step_s, options.stride, options.most_strides, options.tolerance,
                [&](double step, MeasuredTrial& trial) { return trials.grows(step, trial); });
}

MeasuredStep measure_stable_step_from(BodyStepper& stepper, const MotionState& start,
                                      const MeasureLargeOptions& options) {
  check_positive("first step", options.first_step_s);
  check_positive("tolerance", options.tolerance);
  check_positive("energy factor", options.energy_factor);
  const auto grows = [&](double step, MeasuredTrial& trial) {
    WatchOptions watch;
    watch.step_s = step;
    watch.steps = options.steps;
    watch.energy_factor = options.energy_factor;
    const WatchedRun run = watch_motion(stepper, start, watch);
    trial.steps = run.steps;
    return is_unstable(run.outcome);
  };
  return bisect(options.first_step_s, 2.0, options.most_doublings, options.tolerance, grows);
}

}  // namespace palpate::dynamics

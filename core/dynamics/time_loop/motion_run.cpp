#include "core/dynamics/time_loop/motion_run.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "core/base/enum_names.h"
#include "core/base/error.h"
#include "core/mesh/geometry.h"

namespace palpate::dynamics {
namespace {

constexpr EnumNames<MotionOutcome, 5> kOutcomeNames{
    "a motion's outcome", {"completed", "inverted", "diverged", "unsolved", "stopped"}};

/// The largest squared speed and whether all is finite and within bounds.
struct Scan {
  double speed_sq = 0.0;
  bool is_good = true;
};

Scan scan(const MotionState& state, double bound_sq) {
  Scan out;
  double farthest_sq = 0.0;
  double sum = 0.0;  // keeps what is not finite
  for (std::size_t v = 0; v < state.displacement_m.size(); ++v) {
    const double away_sq = length_sq(state.displacement_m[v]);
    const double speed_sq = length_sq(state.velocity_m_s[v]);
    farthest_sq = std::max(farthest_sq, away_sq);
    out.speed_sq = std::max(out.speed_sq, speed_sq);
    sum += away_sq + speed_sq;
  }
  out.is_good = std::isfinite(sum) && farthest_sq <= bound_sq;
  return out;
}

Index find_bad_vertex(const MotionState& state, double bound_sq) {
  for (std::size_t v = 0; v < state.displacement_m.size(); ++v) {
    const double sum = length_sq(state.displacement_m[v]) + length_sq(state.velocity_m_s[v]);
    if (!std::isfinite(sum) || length_sq(state.displacement_m[v]) > bound_sq) return static_cast<Index>(v);
  }
  return kNoIndex;
}

bool is_all_finite(const MotionState& state) {
  const auto all = [](const std::vector<Vec3>& field) {
    return std::all_of(field.begin(), field.end(), [](const Vec3& each) { return is_finite(each); });
  };
  return all(state.displacement_m) && all(state.velocity_m_s);
}

void add(const StepReport& step, MotionReport& report) {
  ++report.steps;
  report.zero_length_springs += step.zero_length_springs;
  report.speeds_cut += step.speeds_cut;
  report.steps_with_cuts += step.speeds_cut > 0 ? 1 : 0;
  report.solver_iterations += step.iterations;
  report.steps_unsolved += step.solved ? 0 : 1;
  if (step.residual_relative)
    report.residual_worst = std::max(report.residual_worst.value_or(0.0), *step.residual_relative);
}

void observe(const MotionModel& model, const MotionState& state, std::uint64_t step,
             const MotionObserver& observer, MotionReport& report) {
  report.inverted_tets = count_volume(model, state).inverted;
  report.inverted_tets_most = std::max(report.inverted_tets_most, report.inverted_tets);
  if (report.inverted_tets > 0 && report.first_inversion_s < 0.0) report.first_inversion_s = state.time_s;
  if (observer) observer(step, state);
}

}  // namespace

MotionOutcome name_end(const MotionReport& report, bool is_good, bool is_stopped) {
  if (!is_good) return MotionOutcome::kDiverged;
  if (is_stopped) return MotionOutcome::kStopped;
  if (report.inverted_tets > 0) return MotionOutcome::kInverted;
  return report.steps_unsolved > 0 ? MotionOutcome::kUnsolved : MotionOutcome::kCompleted;
}

const char* motion_outcome_name(MotionOutcome outcome) {
  return kOutcomeNames.of(outcome);
}

MotionReport run_motion(Integrator& integrator, MotionState& state, const MotionRunOptions& options,
                        const MotionObserver& observer) {
  if (!(options.step_s > 0.0) || !std::isfinite(options.step_s))
    throw InputError("time_step_s", 0, "a finite number above zero", std::to_string(options.step_s));
  const MotionModel& model = integrator.forces().model();
  const double bound = options.escape_ratio * longest_side(bounding_box(model.elastic.rest));
  const double bound_sq = bound > 0.0 ? bound * bound : std::numeric_limits<double>::max();
  MotionReport report;
  Scan seen = scan(state, bound_sq);
  std::uint64_t observed = 0;
  const auto look = [&] {
    observe(model, state, report.steps, observer, report);
    observed = report.steps;
  };
  if (seen.is_good) look();
  bool is_stopped = false;
  while (seen.is_good && report.steps < options.steps) {
    is_stopped = options.should_stop && options.should_stop();
    if (is_stopped) break;
    add(integrator.step(state, options.step_s), report);
    seen = scan(state, bound_sq);
    if (!seen.is_good) break;
    report.peak_speed_m_s = std::max(report.peak_speed_m_s, std::sqrt(seen.speed_sq));
    const bool is_due = options.observe_every > 0 && report.steps % options.observe_every == 0;
    if (is_due || report.steps == options.steps) look();
  }
  if (!seen.is_good) {
    report.first_bad_vertex = find_bad_vertex(state, bound_sq);
    report.is_finite = is_all_finite(state);
    if (report.is_finite) report.peak_speed_m_s = std::max(report.peak_speed_m_s, std::sqrt(seen.speed_sq));
  }
  if (report.is_finite && (report.steps > observed || (!seen.is_good && report.steps == 0))) look();
  report.outcome = name_end(report, seen.is_good, is_stopped);
  report.state_hash = hash_state(state);
  return report;
}

}  // namespace palpate::dynamics

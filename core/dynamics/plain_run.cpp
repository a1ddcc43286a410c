#include "core/dynamics/plain_run.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "core/base/error.h"
#include "core/mesh/geometry.h"

namespace palpate::dynamics {
namespace {

/// How far from the centre a vertex may go; at least one metre for a body without size.
double find_escape(const MotionModel& model, double ratio) {
  const BoundingBox box = bounding_box(model.elastic.rest);
  const Vec3 size = box.high - box.low;
  const double bound = ratio * std::max({size.x, size.y, size.z});
  return bound > 0.0 ? bound : ratio;
}

bool is_finite_at(const MotionState& state, std::size_t v) {
  return is_finite(state.displacement_m[v]) && is_finite(state.velocity_m_s[v]);
}

/// The first vertex that is not finite or has escaped, and whether all is finite.
void describe_bad(const MotionModel& model, const MotionState& state, double escape, MotionReport& report) {
  const BoundingBox box = bounding_box(model.elastic.rest);
  const Vec3 center = 0.5 * (box.low + box.high);
  report.outcome = MotionOutcome::kDiverged;
  for (std::size_t v = 0; v < state.displacement_m.size(); ++v) {
    const bool finite = is_finite_at(state, v);
    report.is_finite = report.is_finite && finite;
    const bool away =
        !finite || length_sq(model.elastic.rest[v] + state.displacement_m[v] - center) > escape * escape;
    if (away && report.first_bad_vertex == kNoIndex) report.first_bad_vertex = static_cast<Index>(v);
  }
}

void observe(const MotionModel& model, const MotionState& state, const MotionObserver& observer,
             MotionReport& report) {
  report.inverted_tets = count_volume(model, state).inverted;
  report.inverted_tets_most = std::max(report.inverted_tets_most, report.inverted_tets);
  if (report.inverted_tets > 0 && report.first_inversion_s < 0.0) report.first_inversion_s = state.time_s;
  if (observer) observer(report.steps, state);
}

template <typename Real>
MotionReport run(const MotionModel& model, MotionState& state, const PlainRunOptions& options,
                 const MotionObserver& observer) {
  PlainOptions own{options.threads, options.speed_limit_m_s, find_escape(model, options.run.escape_ratio)};
  PlainEngine<Real> engine(model, own);
  engine.set_state(state);
  MotionReport report;
  observe(model, state, observer, report);
  bool is_good = true;
  while (is_good && report.steps < options.run.steps) {
    std::uint64_t count = options.run.steps - report.steps;
    if (options.run.observe_every > 0) count = std::min(count, options.run.observe_every);
    const PlainReport part = engine.step(options.run.step_s, count);
    report.steps += part.steps;
    report.zero_length_springs += part.steps_with_zero_length;
    report.speeds_cut += part.speeds_cut;
    report.steps_with_cuts += part.steps_with_cuts;
    report.peak_speed_m_s = std::max(report.peak_speed_m_s, part.peak_speed_m_s);
    state = engine.state();
    is_good = !part.diverged;
    if (is_good) observe(model, state, observer, report);
  }
  if (!is_good) {
    describe_bad(model, state, own.escape_m, report);
  } else if (report.inverted_tets > 0) {
    report.outcome = MotionOutcome::kInverted;
  }
  report.state_hash = hash_state(state);
  return report;
}

}  // namespace

MotionReport run_plain_motion(const MotionModel& model, MotionState& state, const PlainRunOptions& options,
                              const MotionObserver& observer) {
  if (!(options.run.step_s > 0.0) || !std::isfinite(options.run.step_s))
    throw InputError("time_step_s", 0, "a finite number above zero", std::to_string(options.run.step_s));
  return options.single_precision ? run<float>(model, state, options, observer)
                                  : run<double>(model, state, options, observer);
}

}  // namespace palpate::dynamics

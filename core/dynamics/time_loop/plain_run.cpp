#include "core/dynamics/time_loop/plain_run.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "core/base/error.h"
#include "core/base/stopwatch.h"
#include "core/dynamics/motion/motion_forces.h"
#include "core/dynamics/tet_engine/tet_engine.h"
#include "core/mesh/geometry.h"

namespace palpate::dynamics {
namespace {

/// How far from the centre a vertex may go; at least one metre for a body without size.
double find_escape(const MotionModel& model, double ratio) {
  const double bound = ratio * longest_side(bounding_box(model.elastic.rest));
  return bound > 0.0 ? bound : ratio;
}

bool is_finite_at(const MotionState& state, std::size_t v) {
  return is_finite(state.displacement_m[v]) && is_finite(state.velocity_m_s[v]);
}

/// The first vertex that is not finite or has escaped, and whether all is finite.
void describe_bad(const MotionModel& model, const MotionState& state, double escape, MotionReport& report) {
  const BoundingBox box = bounding_box(model.elastic.rest);
  const Vec3 center = 0.5 * (box.low + box.high);
  for (std::size_t v = 0; v < state.displacement_m.size(); ++v) {
    const bool finite = is_finite_at(state, v);
    if (finite) report.peak_speed_m_s = std::max(report.peak_speed_m_s, length(state.velocity_m_s[v]));
    report.is_finite = report.is_finite && finite;
    const bool away =
        !finite || length_sq(model.elastic.rest[v] + state.displacement_m[v] - center) > escape * escape;
    if (away && report.first_bad_vertex == kNoIndex) report.first_bad_vertex = static_cast<Index>(v);
  }
}

void observe_plain(const MotionModel& model, const MotionState& state, const MotionObserver& observer,
                   MotionReport& report) {
  report.inverted_tets = count_volume(model, state).inverted;
  report.inverted_tets_most = std::max(report.inverted_tets_most, report.inverted_tets);
  if (report.inverted_tets > 0 && report.first_inversion_s < 0.0) report.first_inversion_s = state.time_s;
  if (observer) observer(report.steps, state);
}

/// How many steps to take before looking up: as many as took less than some 10 ms, from one on.
class Stretch {
 public:
  std::uint64_t steps() const { return steps_; }

  template <typename Work>
  PlainReport time(const Work& work) {
    const Stopwatch watch;
    const PlainReport report = work();
    const double took_s = watch.seconds();
    if (took_s > kMost && steps_ > 1) steps_ /= 2;
    if (took_s < 0.25 * kMost) steps_ = std::min<std::uint64_t>(2 * steps_, std::uint64_t{1} << 40U);
    return report;
  }

 private:
  static constexpr double kMost = 0.01;
  std::uint64_t steps_ = 1;
};

/// Engine is PlainEngine or TetEngine.
template <typename Engine>
MotionReport run(const MotionModel& model, MotionState& state, const PlainRunOptions& options,
                 const MotionObserver& observer) {
  PlainOptions own{options.threads, options.speed_limit_m_s, find_escape(model, options.run.escape_ratio)};
  Engine engine(model, own);
  engine.set_state(state);
  MotionReport report;
  observe_plain(model, state, observer, report);
  bool is_good = true;
  bool is_stopped = false;
  Stretch stretch;
  while (is_good && report.steps < options.run.steps) {
    is_stopped = options.run.should_stop && options.run.should_stop();
    if (is_stopped) break;
    std::uint64_t due = options.run.steps - report.steps;
    if (options.run.observe_every > 0)
      due = std::min(due, options.run.observe_every - report.steps % options.run.observe_every);
    const std::uint64_t count = options.run.should_stop ? std::min(due, stretch.steps()) : due;
    const PlainReport part = stretch.time([&] { return engine.step(options.run.step_s, count); });
    report.steps += part.steps;
    report.zero_length_springs += part.steps_with_zero_length;
    report.speeds_cut += part.speeds_cut;
    report.steps_with_cuts += part.steps_with_cuts;
    report.peak_speed_m_s = std::max(report.peak_speed_m_s, part.peak_speed_m_s);
    is_good = !part.diverged;
    if (is_good && part.steps < due) continue;
    state = engine.state();
    if (is_good) observe_plain(model, state, observer, report);
  }
  if (is_stopped && state.time_s != engine.state().time_s) {
    state = engine.state();
    observe_plain(model, state, observer, report);
  }
  if (!is_good) {
    describe_bad(model, state, own.escape_m, report);
    if (report.is_finite) observe_plain(model, state, observer, report);
  }
  report.outcome = name_end(report, is_good, is_stopped);
  report.state_hash = hash_state(state);
  return report;
}

void check_step(const PlainRunOptions& options) {
  if (!(options.run.step_s > 0.0) || !std::isfinite(options.run.step_s))
    throw InputError("time_step_s", 0, "a finite number above zero", std::to_string(options.run.step_s));
}

double last_bit(double x) {
  const auto single = static_cast<float>(std::abs(x));
  return static_cast<double>(std::nextafter(single, std::numeric_limits<float>::infinity()) - single);
}

}  // namespace

double rounding_gain_per_step(const MotionModel& model) {
  const std::vector<Vec3>& rest = model.elastic.rest;
  const BoundingBox box = bounding_box(rest);
  const Vec3 center = 0.5 * (box.low + box.high);
  BlockMatrix stiffness = build_motion_pattern(model);
  add_motion_stiffness(model, std::vector<Vec3>(rest.size()), TangentKind::kExact, stiffness);
  std::vector<std::uint8_t> held(rest.size());
  for (const HeldComponent& each : find_held(model))
    held[each.vertex] = static_cast<std::uint8_t>(held[each.vertex] | (1U << each.axis));
  double gain = 0.0;
  for (std::size_t v = 0; v < rest.size(); ++v) {
    const Vec3 x = rest[v] - center;
    const std::array<double, 3> place{x.x, x.y, x.z};
    for (std::size_t k = stiffness.offsets[v]; k < stiffness.offsets[v + 1]; ++k) {
      if (stiffness.columns[k] != v) continue;
      for (std::size_t i = 0; i < 3; ++i) {
        const double bit = last_bit(place.at(i));
        if (((static_cast<unsigned>(held[v]) >> i) & 1U) == 0)
          gain += 0.5 * stiffness.blocks[k](i, i) * bit * bit / 12.0;
      }
    }
  }
  return gain;
}

MotionReport run_plain_motion(const MotionModel& model, MotionState& state, const PlainRunOptions& options,
                              const MotionObserver& observer) {
  check_step(options);
  return options.single_precision ? run<PlainEngine<float>>(model, state, options, observer)
                                  : run<PlainEngine<double>>(model, state, options, observer);
}

MotionReport run_tet_motion(const MotionModel& model, MotionState& state, const PlainRunOptions& options,
                            const MotionObserver& observer) {
  check_step(options);
  return options.single_precision ? run<TetEngine<float>>(model, state, options, observer)
                                  : run<TetEngine<double>>(model, state, options, observer);
}

}  // namespace palpate::dynamics

#include "reference/extremes/extreme_run.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/stopwatch.h"
#include "core/dynamics/stability/measured_step.h"
#include "core/dynamics/stability/stability.h"
#include "core/dynamics/stability/step_map.h"
#include "core/dynamics/time_loop/motion_outcome.h"
#include "reference/door/json_file.h"
#include "reference/door/request_options.h"
#include "reference/extremes/extreme_body.h"
#include "reference/extremes/extreme_method.h"
#include "reference/extremes/run_history.h"

namespace palpate::reference {
namespace {

using dynamics::IntegratorKind;
using dynamics::MotionModel;
using dynamics::MotionState;
using nlohmann::json;

/// Of the start's energy, which nothing adds to: more is growth. Bounded motions just below the bound have up
/// to some 25 times.
constexpr double kEnergyFactor = 100.0;

/// Steps of the runs, over the measured one; over the row sums' of symplectic Euler for the implicit ones.
constexpr std::array<double, 4> kFactors{0.98, 1.02, 2.0, 10.0};
constexpr std::array<double, 4> kImplicitFactors{0.98, 10.0, 100.0, 1e4};

/// Vertices of the largest body whose step map is looked at.
constexpr std::size_t kMostForMap = 120;

/// Of explicit Euler beyond its bound: how much its fastest motion is given room to grow, so that it is seen
/// over all that moves at the start; and how many steps that may take.
constexpr double kShownGrowth = 1e4;
constexpr double kMostSteps = 1e5;

/// What is asked beside the body.
struct Wanted {
  bool measures = true;
  bool is_large = false;
  double step_factor = 0.9;
  bool is_unit_rate = false;
  std::uint64_t steps = 1000;
  std::uint64_t horizon = 16384;
  double time_limit_s = 60.0;
};

Wanted take_wanted(json& options) {
  constexpr double kHuge = std::numeric_limits<double>::max();
  Wanted out;
  out.measures = take_choice(options, "task", {"measure", "run"}) == 0;
  out.is_large = take_choice(options, "regime", {"small", "large"}) == 1;
  out.step_factor = take_number(options, "step_factor", 0.0, kHuge, out.step_factor);
  if (!(out.step_factor > 0.0)) throw InputError("step_factor", 0, "a number above zero", "0");
  out.is_unit_rate = take_choice(options, "step_unit", {"bound", "rate"}) == 1;
  out.steps = static_cast<std::uint64_t>(take_whole(options, "steps", 1, 1'000'000'000'000, 1000));
  out.horizon = static_cast<std::uint64_t>(take_whole(options, "horizon", 512, 1'000'000'000, 16384));
  out.time_limit_s = take_number(options, "time_limit_s", 0.0, kHuge, out.time_limit_s);
  return out;
}

/// Predictions, the measurement and the runs of one request.
class ExtremeRun {
 public:
  ExtremeRun(const ExtremeMethod& method, const Wanted& wanted, const BuiltBody& body,
             const StabilityTask& task, int threads)
      : method_(method),
        wanted_(wanted),
        body_(body),
        task_(task),
        threads_(threads),
        seed_(task.problem.seed),
        start_(start_at_rest(body.model)) {
    start_.displacement_m = task.problem.start_m;
  }

  json report() {
    predict();
    if (wanted_.measures) {
      measure();
      for (const double factor : method_.has_no_bound() ? kImplicitFactors : kFactors)
        run_at(factor * around_);
    } else {
      run_at(wanted_.step_factor * unit());
    }
    // The outcome of a measurement is how the body fails just beyond what was measured.
    report_["outcome"] = report_["runs"].at(wanted_.measures ? 1 : 0).at("outcome");
    return report_;
  }

  /// The answer's file; after report().
  json history() const {
    return {{"schema", "palpate/stability_answer/1"},
            {"rounding", make(body_.model)->rounding()},
            {"runs", histories_},
            {"bracket", bracket_}};
  }

 private:
  std::unique_ptr<dynamics::BodyStepper> make(const MotionModel& model) const {
    return method_.make(model, task_, threads_);
  }

  /// What the step of a run is counted in.
  double unit() const {
    if (wanted_.is_unit_rate) return 2.0 / body_.report.at("rate_per_s").get<double>();
    return bound_ > 0.0 && std::isfinite(bound_) ? bound_ : reference_s_;
  }

  void predict() {
    const MotionModel& model = body_.model;
    reference_s_ = bound_stable_step(model, IntegratorKind::kSymplecticEuler).step_s;
    dynamics::StableStep stable;
    stable.step_s = stable.step_at_most_s = std::numeric_limits<double>::infinity();
    if (!method_.has_no_bound()) stable = predict_stable_step(model, method_.kind, threads_);
    const double rows = bound_stable_step(model, method_.kind).step_s;
    bound_ = stable.step_s;
    at_most_ = stable.step_at_most_s;
    report_["predicted_step_s"] = number_or_null(bound_);
    report_["predicted_at_most_s"] = number_or_null(at_most_);
    report_["predicted_converged"] = stable.converged;
    // The thesis's force is not symmetric: of its stiffness the norm is taken, which is more than it can do.
    // Of larger bodies, explicit Euler's growth may take longer to show than any horizon.
    report_["predicted_is_exact"] =
        !model.elastic.volume_force &&
        (method_.kind != IntegratorKind::kExplicitEuler || model.elastic.rest.size() <= kMostForMap);
    report_["row_sum_step_s"] = method_.has_no_bound() ? json(nullptr) : number_or_null(rows);
    report_["symplectic_row_sum_step_s"] = number_or_null(reference_s_);
    report_["predicted_at_start_s"] = nullptr;
    if (wanted_.is_large)
      report_["predicted_at_start_s"] =
          number_or_null(predict_stable_step_at(model, method_.kind, start_.displacement_m, threads_).step_s);
    report_["runs"] = json::array();
  }

  /// Explicit Euler just beyond its bound grows by about p a step, p = (h omega)^2: with little damping, no
  /// horizon sees it. Of a small linear body its step's own eigenvalues tell.
  bool is_by_map() const {
    return method_.kind == IntegratorKind::kExplicitEuler && bound_ > 0.0 && std::isfinite(bound_) &&
           !body_.model.elastic.volume_force && body_.model.elastic.rest.size() <= kMostForMap;
  }

  /// Where a step's damping is this small next to 1, no step taken in double precision feels it.
  bool is_below_rounding() const {
    constexpr double kLeast = 1e-6;  // h omega; its square is what damping has to undo
    return method_.kind == IntegratorKind::kExplicitEuler && bound_ > 0.0 && bound_ < kLeast * reference_s_;
  }

  dynamics::MeasuredStep measure_by_map() {
    report_["measured_by"] = "step_map";
    dynamics::MeasureMapOptions options;
    options.first_step_s = 0.99 * bound_;
    options.tolerance = 0.021;  // the next stride up is enough
    const MotionModel model = linearise(body_.model);
    dynamics::MeasuredStep found = measure_stable_step_by_map(*make(model), options);
    rerun_bracket(model, found, kEnergyFactor);
    return found;
  }

  dynamics::MeasuredStep measure_small() {
    if (bound_ == 0.0) {
      report_["measured_by"] = "nothing: no step is stable";
      return {};
    }
    if (is_below_rounding()) {
      report_["measured_by"] = "nothing: rounding hides the damping of a step";
      return {};
    }
    if (is_by_map()) return measure_by_map();
    report_["measured_by"] = "trials";
    dynamics::MeasureStepOptions options;
    options.first_step_s = reference_s_;
    options.seed = seed_;
    options.horizon_least = method_.kind == IntegratorKind::kExplicitEuler ? wanted_.horizon : 1024;
    options.horizon_most = std::max(wanted_.horizon, options.horizon_least);
    if (method_.has_no_bound()) {
      options.horizon_most = options.horizon_least = 512;
      options.stride = 100.0;
      options.most_strides = 2;
    }
    options.amplitude_m = (method_.is_single() ? 1e-6 : 1e-9) * body_.size_m;
    if (method_.is_single())
      options.growth_factor = 1e3;  // there is less room between rounding and large motions
    // The thesis's force and the plain engine have no linear form: there, small motions have to do.
    const bool is_linear = method_.has_linear_form() && !body_.model.elastic.volume_force;
    // The trapezoidal rule turns a fast mode by nearly half a turn a step, and modes that are stepped exactly
    // by any part of one: their kinetic energy comes and goes over more steps than any trial here has, and
    // looks like growth while it comes. In single precision rounding adds to it all the time.
    options.counts_slow_growth = is_linear && method_.kind != IntegratorKind::kTrapezoidal &&
                                 method_.engine != ExtremeMethod::Engine::kModes && !method_.is_single();
    const MotionModel model = is_linear ? linearise(body_.model) : body_.model;
    dynamics::MeasuredStep found = measure_stable_step(*make(model), options);
    // Whether growth is told by itself, without regard to its size: not from what rounding adds.
    const bool is_told = is_linear && !method_.is_single();
    if (found.is_found())
      bracket_ = {{"by", "trials"},
                  {"lower", describe_trial(found.stable_s, is_told, found.stable)},
                  {"upper", describe_trial(found.unstable_s, is_told, found.unstable)}};
    return found;
  }

  /// Runs again at both ends of what was measured, for the histories.
  void rerun_bracket(const MotionModel& model, const dynamics::MeasuredStep& found, double energy_factor) {
    if (!found.is_found()) return;
    const auto rerun = [&](double step, const dynamics::MeasuredTrial& trial) {
      dynamics::WatchOptions watch;
      watch.step_s = step;
      watch.steps = wanted_.steps;
      watch.energy_factor = energy_factor;
      watch.is_known_to_grow = trial.growth > 0.0;
      watch.keeps_rows = true;
      const std::unique_ptr<dynamics::BodyStepper> stepper = make(model);
      const dynamics::WatchedRun seen = watch_motion(*stepper, start_, watch);
      return describe_run(watch, seen, *stepper);
    };
    bracket_ = {{"by", report_.at("measured_by")},
                {"lower", rerun(found.stable_s, found.stable)},
                {"upper", rerun(found.unstable_s, found.unstable)}};
  }

  void measure() {
    dynamics::MeasuredStep found;
    if (wanted_.is_large) {
      report_["measured_by"] = "runs";
      dynamics::MeasureLargeOptions options;
      options.first_step_s = reference_s_;
      options.steps = wanted_.steps;
      found = measure_stable_step_from(*make(body_.model), start_, options);
      rerun_bracket(body_.model, found, options.energy_factor);
    } else {
      found = measure_small();
    }
    const bool is_found = found.is_found();
    around_ = is_found ? found.step_s() : bound_;
    if (!(around_ > 0.0) || !std::isfinite(around_)) around_ = reference_s_;
    report_["measured_step_s"] = is_found ? json(found.step_s()) : json(nullptr);
    report_["measured_stable_s"] = number_or_null(found.stable_s);
    report_["measured_unstable_s"] = number_or_null(found.unstable_s);
    report_["trials"] = found.trials;
    report_["trial_steps"] = found.steps;
    report_["runs_around_s"] = around_;
    json ratio;
    if (is_found && std::isfinite(at_most_) && bound_ > 0.0)
      ratio = found.step_s() / std::clamp(found.step_s(), bound_, at_most_);
    report_["measured_over_predicted"] = ratio;
  }

  /// Whether small motions grow with a step of explicit Euler: by its bound, which is exact.
  bool is_beyond_bound(double step) const {
    return method_.kind == IntegratorKind::kExplicitEuler && !body_.model.elastic.volume_force &&
           std::isfinite(at_most_) && step > 1.001 * at_most_;
  }

  /// |z|^2 - 1 of the fastest growing small motion, from the step's own matrix; 0 where that cannot be told.
  double growth_of(double step) const {
    if (body_.model.elastic.rest.size() > kMostForMap || is_below_rounding()) return 0.0;
    const MotionModel model = linearise(body_.model);
    const double growth = measure_map_growth(*make(model), step);
    return std::isfinite(growth) ? std::max(growth, 0.0) : 0.0;
  }

  /// Steps that explicit Euler beyond its bound needs to show what it does; those asked for otherwise.
  std::uint64_t steps_of(double growth) const {
    if (!(growth > 0.0)) return wanted_.steps;
    const double needed = std::ceil(2.0 * std::log(kShownGrowth) / std::log1p(growth));
    return needed <= kMostSteps ? std::max(wanted_.steps, static_cast<std::uint64_t>(needed)) : wanted_.steps;
  }

  /// One run with the full forces.
  void run_at(double step) {
    json run{{"step_s", number_or_null(step)}, {"step_over_predicted", nullptr}};
    if (bound_ > 0.0 && std::isfinite(bound_)) run["step_over_predicted"] = number_or_null(step / bound_);
    dynamics::WatchOptions watch;
    watch.step_s = step;
    watch.is_known_to_grow = is_beyond_bound(step);
    const double growth = watch.is_known_to_grow ? growth_of(step) : 0.0;
    watch.steps = steps_of(growth);
    watch.energy_factor = kEnergyFactor;
    watch.keeps_rows = true;
    const Stopwatch clock;
    watch.give_up = [&] { return clock.seconds() > wanted_.time_limit_s; };
    const std::unique_ptr<dynamics::BodyStepper> stepper = make(body_.model);
    const dynamics::WatchedRun seen = watch_motion(*stepper, start_, watch);
    run["growth_per_step"] = growth > 0.0 ? number_or_null(growth) : json(nullptr);
    run["steps_unsolved"] = seen.steps_unsolved;
    run["outcome"] = watched_outcome_name(seen.outcome);
    run["steps"] = seen.steps;
    run["time_s"] = number_or_null(seen.time_s);
    run["vertex"] = seen.vertex == kNoIndex ? json(nullptr) : json(seen.vertex);
    run["energy_start_j"] = number_or_null(seen.energy_start_j);
    run["energy_most_j"] = number_or_null(seen.energy_most_j);
    run["kinetic_end_j"] = number_or_null(seen.kinetic_end_j);
    run["drift_over_size"] = number_or_null(seen.drift_m / body_.size_m);
    run["inverted_start"] = seen.inverted_start;
    run["inverted_end"] = seen.inverted_end;
    run["seconds"] = clock.seconds();
    report_["runs"].push_back(run);
    histories_.push_back(describe_run(watch, seen, *stepper));
  }

  const ExtremeMethod& method_;
  const Wanted& wanted_;
  const BuiltBody& body_;
  const StabilityTask& task_;
  int threads_;
  std::uint64_t seed_;
  MotionState start_;
  double reference_s_ = 0.0;  ///< row sums of symplectic Euler: of the body's own time
  double bound_ = 0.0;
  double at_most_ = 0.0;
  double around_ = 0.0;
  json report_ = json::object();
  json histories_ = json::array();
  json bracket_;
};

}  // namespace

Response run_extreme(const Request& request) {
  json left = request.options;
  const ExtremeMethod method = take_method(request.method, left);
  const Wanted wanted = take_wanted(left);
  const BodyModel model = take_body_model(left);
  require_all_taken(left);
  if (method.engine == ExtremeMethod::Engine::kModes && wanted.is_large)
    throw InputError("regime", 0, "small: modes are linear", "large");
  const StabilityTask task = read_stability_task(request);
  const Stopwatch clock;
  const BuiltBody built = build_extreme_body(task, model);
  ExtremeRun run(method, wanted, built, task, request.threads);
  Response response;
  response.report = built.report;
  response.report["method"] = request.method;
  response.report.update(run.report());
  response.kernel_s = clock.seconds();
  write_file_atomically(request.output, run.history().dump() + "\n");
  return response;
}

}  // namespace palpate::reference

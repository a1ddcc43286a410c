#include "reference/extremes/extreme_run.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/dynamics/stability/measured_step.h"
#include "core/dynamics/stability/stability.h"
#include "core/dynamics/stability/step_map.h"
#include "core/dynamics/time_loop/motion_outcome.h"
#include "core/mesh/geometry.h"
#include "core/mesh/io/medit.h"
#include "reference/door/request_options.h"
#include "reference/extremes/extreme_body.h"

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

class Stopwatch {
 public:
  double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// A number, or null where there is none.
json number_or_null(double value) {
  return std::isfinite(value) ? json(value) : json(nullptr);
}

/// The integrator that a method names, or the plain engine.
struct Method {
  std::string name;
  IntegratorKind kind = IntegratorKind::kSymplecticEuler;
  bool is_plain = false;
  dynamics::Precision precision = dynamics::Precision::kDouble;

  bool is_implicit() const {
    return kind == IntegratorKind::kImplicitEuler || kind == IntegratorKind::kPrefactored;
  }

  std::unique_ptr<dynamics::BodyStepper> make(const MotionModel& model, int threads) const {
    if (is_plain) return dynamics::make_plain_stepper(model, precision, threads);
    dynamics::IntegratorOptions options;
    options.kind = kind;
    options.threads = threads;
    options.linear.threads = threads;
    return dynamics::make_stepper(model, options);
  }
};

Method parse_method(const std::string& name) {
  const std::string prefix = "motion.";
  if (!name.starts_with(prefix)) throw InputError("method", 0, "motion.INTEGRATOR", name);
  Method out;
  out.name = name.substr(prefix.size());
  out.is_plain = out.name == "plain_double" || out.name == "plain_float";
  if (out.name == "plain_float") out.precision = dynamics::Precision::kSingle;
  if (!out.is_plain) out.kind = dynamics::parse_integrator(out.name);
  return out;
}

/// What is asked beside the body.
struct Wanted {
  bool measures = true;
  bool is_large = false;
  std::size_t start = 0;  ///< random, stretch, shear, invert
  double strain = 1e-6;
  double step_factor = 0.9;
  bool is_unit_rate = false;
  std::uint64_t steps = 1000;
  std::uint64_t horizon = 16384;
  std::uint64_t seed = 1;
  double time_limit_s = 60.0;
};

Wanted take_wanted(json& options) {
  constexpr double kHuge = std::numeric_limits<double>::max();
  Wanted out;
  out.measures = take_choice(options, "task", {"measure", "run"}) == 0;
  out.is_large = take_choice(options, "regime", {"small", "large"}) == 1;
  out.start = take_choice(options, "start", {"random", "stretch", "shear", "invert"});
  out.strain = take_number(options, "strain", -kHuge, kHuge, out.strain);
  out.step_factor = take_number(options, "step_factor", 0.0, kHuge, out.step_factor);
  if (!(out.step_factor > 0.0)) throw InputError("step_factor", 0, "a number above zero", "0");
  out.is_unit_rate = take_choice(options, "step_unit", {"bound", "rate"}) == 1;
  out.steps = static_cast<std::uint64_t>(take_whole(options, "steps", 1, 1'000'000'000'000, 1000));
  out.horizon = static_cast<std::uint64_t>(take_whole(options, "horizon", 512, 1'000'000'000, 16384));
  out.time_limit_s = take_number(options, "time_limit_s", 0.0, kHuge, out.time_limit_s);
  return out;
}

Vec3& clear_if_held(const dynamics::Loads& loads, std::size_t v, Vec3& u) {
  if (loads.held[v] != 0) u = {};
  return u;
}

/// Where a run starts.
MotionState make_start(const BuiltBody& body, const Wanted& wanted) {
  MotionState state = start_at_rest(body.model);
  const std::vector<Vec3>& rest = body.model.elastic.rest;
  const BoundingBox box = bounding_box(rest);
  const double low = box.low.x;
  const double mirror = 0.25 * box.low.x + 0.75 * box.high.x;
  SplitMix64 random(wanted.seed);
  const auto next = [&] { return wanted.strain * body.size_m * (2.0 * random.uniform() - 1.0); };
  for (std::size_t v = 0; v < rest.size(); ++v) {
    Vec3& u = state.displacement_m[v];
    if (wanted.start == 0) u = {next(), next(), next()};
    if (wanted.start == 1) u.x = wanted.strain * (rest[v].x - low);
    if (wanted.start == 2) u.y = wanted.strain * (rest[v].x - low);
    if (wanted.start == 3 && rest[v].x > mirror) u.x = -2.0 * wanted.strain * (rest[v].x - mirror);
    clear_if_held(body.model.loads[0].loads, v, u);
  }
  return state;
}

/// Predictions, the measurement and the runs of one request.
class ExtremeRun {
 public:
  ExtremeRun(const Method& method, const Wanted& wanted, const BuiltBody& body, int threads)
      : method_(method), wanted_(wanted), body_(body), threads_(threads), start_(make_start(body, wanted)) {}

  json report() {
    predict();
    if (wanted_.measures) {
      measure();
      for (const double factor : method_.is_implicit() ? kImplicitFactors : kFactors)
        run_at(factor * around_);
    } else {
      run_at(wanted_.step_factor * unit());
    }
    // The outcome of a measurement is how the body fails just beyond what was measured.
    report_["outcome"] = report_["runs"].at(wanted_.measures ? 1 : 0).at("outcome");
    return report_;
  }

 private:
  /// What the step of a run is counted in.
  double unit() const {
    if (wanted_.is_unit_rate) return 2.0 / body_.report.at("rate_per_s").get<double>();
    return bound_ > 0.0 && std::isfinite(bound_) ? bound_ : reference_s_;
  }

  void predict() {
    const MotionModel& model = body_.model;
    reference_s_ = bound_stable_step(model, IntegratorKind::kSymplecticEuler).step_s;
    const dynamics::StableStep stable = predict_stable_step(model, method_.kind, threads_);
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
    report_["row_sum_step_s"] = method_.is_implicit() ? json(nullptr) : number_or_null(rows);
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
    return measure_stable_step_by_map(*method_.make(model, threads_), options);
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
    options.seed = wanted_.seed;
    options.horizon_least = method_.kind == IntegratorKind::kExplicitEuler ? wanted_.horizon : 1024;
    options.horizon_most = std::max(wanted_.horizon, options.horizon_least);
    if (method_.is_implicit()) {
      options.horizon_most = options.horizon_least = 512;
      options.stride = 100.0;
      options.most_strides = 2;
    }
    const bool is_single = method_.is_plain && method_.precision == dynamics::Precision::kSingle;
    options.amplitude_m = (is_single ? 1e-6 : 1e-9) * body_.size_m;
    if (is_single) options.growth_factor = 1e3;  // there is less room between rounding and large motions
    // The thesis's force and the plain engine have no linear form: there, small motions have to do.
    const bool is_linear = !method_.is_plain && !body_.model.elastic.volume_force;
    options.counts_slow_growth = is_linear;
    const MotionModel model = is_linear ? linearise(body_.model) : body_.model;
    return measure_stable_step(*method_.make(model, threads_), options);
  }

  void measure() {
    dynamics::MeasuredStep found;
    if (wanted_.is_large) {
      report_["measured_by"] = "runs";
      dynamics::MeasureLargeOptions options;
      options.first_step_s = reference_s_;
      options.steps = wanted_.steps;
      found = measure_stable_step_from(*method_.make(body_.model, threads_), start_, options);
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
    const double growth = measure_map_growth(*method_.make(model, threads_), step);
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
    const Stopwatch clock;
    watch.give_up = [&] { return clock.seconds() > wanted_.time_limit_s; };
    const std::unique_ptr<dynamics::BodyStepper> stepper = method_.make(body_.model, threads_);
    const dynamics::WatchedRun seen = watch_motion(*stepper, start_, watch);
    run["growth_per_step"] = growth > 0.0 ? number_or_null(growth) : json(nullptr);
    run["steps_unsolved"] = stepper->steps_unsolved();
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
  }

  const Method& method_;
  const Wanted& wanted_;
  const BuiltBody& body_;
  int threads_;
  MotionState start_;
  double reference_s_ = 0.0;  ///< row sums of symplectic Euler: of the body's own time
  double bound_ = 0.0;
  double at_most_ = 0.0;
  double around_ = 0.0;
  json report_ = json::object();
};

}  // namespace

Response run_extreme(const Request& request) {
  const Method method = parse_method(request.method);
  json left = request.options;
  Wanted wanted = take_wanted(left);
  ExtremeBody body = take_extreme_body(left);
  wanted.seed = body.mesh.seed = static_cast<std::uint64_t>(take_whole(left, "seed", 0, 1LL << 40, 1));
  require_all_taken(left);
  const TetMesh mesh = read_medit(request.input).mesh;
  const Stopwatch clock;
  const BuiltBody built = build_extreme_body(mesh, body);
  Response response;
  response.report = built.report;
  response.report["method"] = request.method;
  response.report.update(ExtremeRun(method, wanted, built, request.threads).report());
  response.kernel_s = clock.seconds();
  return response;
}

}  // namespace palpate::reference

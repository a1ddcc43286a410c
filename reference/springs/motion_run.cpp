#include "reference/springs/motion_run.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

#include "core/base/error.h"
#include "core/base/stopwatch.h"
#include "core/dynamics/stability/stability.h"
#include "core/dynamics/time_loop/motion_run.h"
#include "reference/door/request_options.h"
#include "reference/elastic_models/model_request.h"
#include "reference/springs/motion_phases.h"

namespace palpate::reference {
namespace {

using dynamics::MotionOutcome;
using dynamics::MotionState;
using nlohmann::json;

constexpr double kMostSteps = 1e9;

struct Options {
  dynamics::IntegratorOptions integrator;
  double time_step_s = 0.0;
  double safety = 0.9;
  DampingModel damping = DampingModel::kRayleigh;
};

Options take_options(int threads, json& left) {
  Options out;
  out.integrator.kind = dynamics::parse_integrator(take_option<std::string>(
      left, "integrator", &json::is_string, "the name of an integrator", "symplectic_euler"));
  out.integrator.threads = threads;
  out.integrator.linear.threads = threads;
  out.time_step_s = take_number(left, "time_step_s", 0.0, 1e6, 0.0);
  out.safety = take_number(left, "safety", 1e-6, 1.0, out.safety);
  dynamics::StepSolverOptions& solver = out.integrator.solver;
  solver.iterations = static_cast<std::size_t>(
      take_whole(left, "iterations", 1, 100'000, static_cast<long long>(solver.iterations)));
  solver.tolerance = take_number(left, "tolerance", 0.0, 1.0, solver.tolerance);
  out.integrator.substeps = static_cast<std::size_t>(take_whole(left, "substeps", 1, 10'000, 1));
  constexpr std::array kModels{DampingModel::kRayleigh, DampingModel::kSprings, DampingModel::kVertices};
  if (left.contains("damping"))
    out.damping = kModels[take_choice(left, "damping", {"rayleigh", "springs", "vertices"})];
  return out;
}

/// The shortest of the phases' bounds; infinity for the implicit integrators.
double find_stable_step(const MovingPhases& moving, const dynamics::IntegratorOptions& integrator) {
  double least = std::numeric_limits<double>::infinity();
  if (is_implicit(integrator.kind)) return least;
  for (const MovingPhase& phase : moving.phases) {
    const dynamics::StableStep found = predict_stable_step(phase.model, integrator.kind, integrator.threads);
    least = std::min(least,
                     found.converged ? found.step_s : bound_stable_step(phase.model, integrator.kind).step_s);
  }
  return least;
}

double choose_step(const Options& options, double stable_step_s) {
  const std::string name = dynamics::integrator_name(options.integrator.kind);
  if (options.time_step_s > stable_step_s)
    throw InputError("time_step_s", 0,
                     "at most the stable step of " + name + ", " + json(stable_step_s).dump(),
                     json(options.time_step_s).dump());
  if (options.time_step_s > 0.0) return options.time_step_s;
  if (!std::isfinite(stable_step_s))
    throw InputError("time_step_s", 0, "a number of seconds for " + name + ", which has no bound", "0");
  if (!(stable_step_s > 0.0)) throw InputError("time_step_s", 0, "a stable step of " + name, "none");
  return options.safety * stable_step_s;
}

/// Takes the phases one after the other.
class PhaseRunner {
 public:
  PhaseRunner(const MotionProblem& problem, const MovingPhases& moving, const Options& options, double step_s)
      : problem_(problem), moving_(moving), options_(options), step_s_(step_s) {
    double steps = 0.0;
    for (const MovingPhase& phase : moving.phases) steps += steps_of(phase);
    if (!(steps <= kMostSteps)) throw InputError("time_step_s", 0, "at most 1e9 steps", json(steps).dump());
    stride_ =
        static_cast<std::uint64_t>(std::ceil(steps / static_cast<double>(problem.samples) * (1.0 - 1e-12)));
    history_.columns = history_columns(problem);
  }

  void run() {
    state_ = start_at_rest(moving_.phases.front().model);
    for (const MovingPhase& phase : moving_.phases) {
      run_phase(phase);
      if (outcome_ == MotionOutcome::kDiverged) return;
    }
  }

  void report(json& out) const {
    out["outcome"] = motion_outcome_name(outcome_);
    out["steps"] = steps_;
    out["time_step_s"] = longest_step_s_;
    out["solver_iterations"] = iterations_;
    out["steps_unsolved"] = unsolved_;
    out["residual_worst"] = residual_worst_ ? json(*residual_worst_) : json(nullptr);
    out["inverted_tets"] = inverted_;
  }

  const MotionHistory& history() const { return history_; }
  MotionOutcome outcome() const { return outcome_; }
  double watching_s() const { return watching_s_; }

 private:
  double steps_of(const MovingPhase& phase) const {
    return std::ceil((phase.time.to_s - phase.time.from_s) / step_s_ * (1.0 - 1e-12));
  }

  void run_phase(const MovingPhase& phase) {
    dynamics::Integrator integrator(phase.model, options_.integrator);
    state_.time_s = phase.time.from_s;
    integrator.forces().impose(state_.time_s, state_.displacement_m, state_.velocity_m_s);
    dynamics::MotionRunOptions run;
    run.steps = static_cast<std::uint64_t>(steps_of(phase));
    run.step_s = (phase.time.to_s - phase.time.from_s) / static_cast<double>(run.steps);
    run.observe_every = stride_;
    longest_step_s_ = std::max(longest_step_s_, run.step_s);
    const bool is_first = steps_ == 0;
    const auto watch = [&](std::uint64_t step, const MotionState& state) {
      const Stopwatch watching;
      const bool is_end = step == run.steps;
      if (step > 0 || is_first)
        add_row(phase, integrator.forces(), state, is_end ? phase.time.to_s : state.time_s);
      watching_s_ += watching.seconds();
    };
    const dynamics::MotionReport done = run_motion(integrator, state_, run, watch);
    outcome_ = done.outcome;
    steps_ += done.steps;
    iterations_ += done.solver_iterations;
    unsolved_ += done.steps_unsolved;
    if (done.residual_worst) residual_worst_ = std::max(residual_worst_.value_or(0.0), *done.residual_worst);
    inverted_ = done.inverted_tets;
    if (outcome_ == MotionOutcome::kCompleted && unsolved_ > 0) outcome_ = MotionOutcome::kUnsolved;
  }

  void add_row(const MovingPhase& phase, dynamics::MotionForces& forces, const MotionState& state,
               double time_s) {
    const dynamics::MotionEnergy energy = measure_energy(phase.model, state);
    HistoryMoment moment{time_s,        energy.kinetic_j,           energy.elastic_j,
                         energy.load_j, forces.group_forces(state), {}};
    for (const Index probe : problem_.probes) moment.probe_m.push_back(state.displacement_m[probe]);
    history_.rows.push_back(history_row(problem_, phase.time, moment));
  }

  const MotionProblem& problem_;
  const MovingPhases& moving_;
  const Options& options_;
  double step_s_;
  std::uint64_t stride_ = 1;
  MotionState state_;
  MotionHistory history_;
  MotionOutcome outcome_ = MotionOutcome::kCompleted;
  std::uint64_t steps_ = 0;
  std::uint64_t iterations_ = 0;
  std::uint64_t unsolved_ = 0;
  std::optional<double> residual_worst_;
  std::size_t inverted_ = 0;
  double longest_step_s_ = 0.0;
  double watching_s_ = 0.0;
};

}  // namespace

Response run_motion_request(const Request& request) {
  constexpr std::string_view kPrefix = "moving_";
  if (!request.method.starts_with(kPrefix))
    throw InputError("method", 0, "moving_springs.NAME or moving_smoothed.NAME", request.method);
  const MotionTask task = read_motion_task(request);
  json left = request.options;
  const ModelRequest wanted =
      take_model_request(request.method.substr(kPrefix.size()), task.problem.body.strain, left);
  const Options options = take_options(request.threads, left);
  require_all_taken(left);

  Response response;
  response.report = {{"method", request.method},
                     {"integrator", dynamics::integrator_name(options.integrator.kind)},
                     {"vertices", task.mesh.points.size()}};
  const Stopwatch kernel;
  const dynamics::BuiltModel built =
      build_requested_model(task.mesh, task.problem.body.material, wanted, response);
  const double identify_s = kernel.seconds();
  const MovingPhases moving = build_phases(task.mesh, task.problem, built.model, options.damping);
  const double stable_step_s = find_stable_step(moving, options.integrator);
  PhaseRunner runner(task.problem, moving, options, choose_step(options, stable_step_s));
  const double setup_s = kernel.seconds() - identify_s - moving.modes_s;
  const Stopwatch solving;
  runner.run();
  response.report["solve_s"] = solving.seconds() - runner.watching_s();
  response.kernel_s = kernel.seconds() - runner.watching_s() - moving.modes_s;

  runner.report(response.report);
  response.report["setup_s"] = setup_s;
  response.report["frequencies_s"] = moving.modes_s;
  response.report["stable_step_s"] = std::isfinite(stable_step_s) ? json(stable_step_s) : json(nullptr);
  response.report["spring_damping_n_s_per_m"] = moving.spring_damping_n_s_per_m;
  response.report["vertex_damping_n_s_per_m"] = moving.vertex_damping_n_s_per_m;
  if (task.problem.frequencies > 0) response.report["frequencies_hz"] = moving.modes.frequency_hz;
  if (runner.outcome() == MotionOutcome::kCompleted || runner.outcome() == MotionOutcome::kUnsolved)
    write_history(request.output, runner.history());
  return response;
}

}  // namespace palpate::reference

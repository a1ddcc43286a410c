#include "reference/springs/motion_run.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "core/base/error.h"
#include "core/base/stopwatch.h"
#include "core/dynamics/stability/stability.h"
#include "core/dynamics/time_loop/motion_run.h"
#include "reference/door/json_file.h"
#include "reference/door/motion_problem.h"
#include "reference/door/request_options.h"
#include "reference/elastic_models/model_request.h"
#include "reference/elastic_models/stepped_motion.h"
#include "reference/linear_systems/factor.h"
#include "reference/springs/motion_phases.h"

namespace palpate::reference {
namespace {

using dynamics::MotionOutcome;
using dynamics::MotionState;
using nlohmann::json;

constexpr double kMostSteps = 1e9;

struct Options {
  dynamics::IntegratorOptions integrator;
  StepRequest step;
  DampingModel damping = DampingModel::kRayleigh;
};

Options take_options(int threads, json& left) {
  Options out;
  out.integrator.kind = dynamics::parse_integrator(take_option<std::string>(
      left, "integrator", &json::is_string, "the name of an integrator", "symplectic_euler"));
  out.integrator.threads = threads;
  out.integrator.linear.threads = threads;
  out.integrator.linear.factor = choose_factor("auto");
  out.step = take_step_request(left);
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

/// The stable neo-Hookean law makes a body one of large strain, whatever the scene says.
StrainSize strain_of(const MotionTask& task, const json& options) {
  const auto law = options.find("law");
  const char* const stable = dynamics::strain_law_name(dynamics::StrainLaw::kStableNeoHookean);
  return law != options.end() && *law == stable ? StrainSize::kLarge : task.problem.body.strain;
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

/// Takes the phases one after the other.
class PhaseRunner {
 public:
  PhaseRunner(const MotionProblem& problem, const MovingPhases& moving, const Options& options, double step_s)
      : problem_(problem),
        moving_(moving),
        options_(options),
        plan_(plan_steps(problem, step_s, kMostSteps)),
        history_{history_columns(problem), {}},
        states_(problem.duration_s, moving.phases.front().model.mass_kg.size()) {}

  void run() {
    state_ = start_at_rest(moving_.phases.front().model);
    for (std::size_t k = 0; k < moving_.phases.size(); ++k) {
      run_phase(moving_.phases[k], plan_.phases[k]);
      if (report_.outcome == MotionOutcome::kDiverged) return;
    }
  }

  void report(json& out) const {
    out["outcome"] = motion_outcome_name(report_.outcome);
    out["steps"] = report_.steps;
    out["time_step_s"] = longest_step_s_;
    out["solver_iterations"] = report_.solver_iterations;
    out["steps_unsolved"] = report_.steps_unsolved;
    out["residual_worst"] = or_null(report_.residual_worst);
    out["inverted_tets"] = report_.inverted_tets;
  }

  const MotionHistory& history() const { return history_; }
  const MotionStates& states() const { return states_; }
  MotionOutcome outcome() const { return report_.outcome; }
  double watching_s() const { return watching_s_; }

 private:
  void run_phase(const MovingPhase& phase, const PhaseSteps& steps) {
    dynamics::Integrator integrator(phase.model, options_.integrator);
    state_.time_s = phase.time.from_s;
    integrator.forces().impose(state_.time_s, state_.displacement_m, state_.velocity_m_s);
    dynamics::MotionRunOptions run;
    run.steps = steps.steps;
    run.step_s = steps.step_s;
    run.observe_every = plan_.stride;
    longest_step_s_ = std::max(longest_step_s_, run.step_s);
    const bool is_first = report_.steps == 0;
    const auto watch = [&](std::uint64_t step, const MotionState& state) {
      const Stopwatch watching;
      const bool is_end = step == run.steps;
      if (step > 0 || is_first)
        add_row(phase, integrator.forces(), state, is_end ? phase.time.to_s : state.time_s);
      watching_s_ += watching.seconds();
    };
    add_phase(run_motion(integrator, state_, run, watch), report_);
  }

  void add_row(const MovingPhase& phase, dynamics::MotionForces& forces, const MotionState& state,
               double time_s) {
    const dynamics::MotionEnergy energy = measure_energy(phase.model, state);
    HistoryMoment moment{time_s,        energy.kinetic_j,           energy.elastic_j,
                         energy.load_j, forces.group_forces(state), {}};
    for (const Index probe : problem_.probes) moment.probe_m.push_back(state.displacement_m[probe]);
    history_.rows.push_back(history_row(problem_, phase.time, moment));
    if (states_.is_due(time_s)) states_.add(time_s, state.displacement_m);
  }

  const MotionProblem& problem_;
  const MovingPhases& moving_;
  const Options& options_;
  StepPlan plan_;
  MotionHistory history_;
  MotionStates states_;
  MotionState state_;
  dynamics::MotionReport report_;
  double longest_step_s_ = 0.0;
  double watching_s_ = 0.0;
};

}  // namespace

Response run_motion_request(const Request& request) {
  const std::string prefix = "moving_";
  if (!request.method.starts_with(prefix))
    throw InputError("method", 0, "moving_springs.NAME or moving_smoothed.NAME", request.method);
  MotionTask task = read_motion_task(request);
  json left = request.options;
  task.problem.body.strain = strain_of(task, left);
  const ModelRequest wanted =
      take_model_request(request.method.substr(prefix.size()), task.problem.body.strain, left);
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
  PhaseRunner runner(
      task.problem, moving, options,
      choose_time_step(options.step, dynamics::integrator_name(options.integrator.kind), stable_step_s));
  const double setup_s = kernel.seconds() - identify_s - moving.modes_s;
  const Stopwatch solving;
  runner.run();
  response.report["solve_s"] = solving.seconds() - runner.watching_s();
  response.kernel_s = kernel.seconds() - runner.watching_s() - moving.modes_s;

  runner.report(response.report);
  response.report["setup_s"] = setup_s;
  response.report["frequencies_s"] = moving.modes_s;
  response.report["stable_step_s"] = number_or_null(stable_step_s);
  response.report["spring_damping_n_s_per_m"] = moving.spring_damping_n_s_per_m;
  response.report["vertex_damping_n_s_per_m"] = moving.vertex_damping_n_s_per_m;
  if (task.problem.frequencies > 0) response.report["frequencies_hz"] = moving.modes.frequency_hz;
  if (runner.outcome() == MotionOutcome::kCompleted || runner.outcome() == MotionOutcome::kUnsolved) {
    write_history(request.output, runner.history());
    runner.states().write_beside(request.output);
  }
  return response;
}

}  // namespace palpate::reference

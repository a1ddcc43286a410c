#include "reference/reduced/modes/modal_run.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <span>
#include <string>

#include "core/base/error.h"
#include "core/base/stopwatch.h"
#include "core/dynamics/elasticity/loads.h"
#include "core/dynamics/reduced/modal_phase.h"
#include "reference/door/deform_problem.h"
#include "reference/door/motion_problem.h"
#include "reference/door/request_options.h"
#include "reference/elastic_models/stepped_motion.h"
#include "reference/linear_systems/factor.h"
#include "reference/reduced/modes/modal_body.h"
#include "reference/reduced/modes/modal_cost.h"
#include "reference/reduced/modes/modal_options.h"

namespace palpate::reference {
namespace {

using dynamics::BodyForces;
using dynamics::ModalGroup;
using dynamics::ModalPhase;
using nlohmann::json;

/// Of moving_reduced.modal.
struct MovingOptions {
  ModalBodyOptions body;
  double time_step_s = 1e-3;
};

void require_method(const Request& request, const std::string& name) {
  if (request.method != name) throw InputError("method", 0, name, request.method);
}

/// Takes a body through its phases.
class ModalMotion {
 public:
  ModalMotion(const MotionTask& task, const MovingOptions& options)
      : task_(task),
        options_(options),
        body_(task.mesh, task.problem, options.body.order, options.body.factor),
        history_{history_columns(task.problem), {}},
        plan_(plan_steps(task.problem, options.time_step_s, kMostModalSteps)) {}

  void run() {
    dynamics::NodeState state{std::vector<Vec3>(body_.space().nodes()),
                              std::vector<Vec3>(body_.space().nodes())};
    const std::vector<LoadPhase> phases = find_phases(task_.problem);
    for (std::size_t k = 0; k < phases.size(); ++k) {
      const Stopwatch setting_up;
      ModalPhase moving = body_.build_phase(phases[k], options_.body.modal);
      setup_s_ += setting_up.seconds();
      left_out_ = std::max(left_out_, moving.start(state, phases[k].from_s));
      if (k == 0) add_row(moving, phases[k], phases[k].from_s);
      step_through(moving, phases, k);
      state = moving.state();
      frequencies_ = moving.frequencies_hz();
    }
  }

  void report(Response& response) const {
    json& out = response.report;
    out["outcome"] = is_finite_ ? "completed" : "diverged";
    out["steps"] = steps_;
    out["time_step_s"] = longest_step_s_;
    out["identify_s"] = setup_s_;
    out["solve_s"] = stepping_s_;
    out["us_per_step"] = steps_ > 0 ? 1e6 * stepping_s_ / static_cast<double>(steps_) : 0.0;
    out["unknowns"] = 3 * body_.space().nodes();
    out["left_out_at_phases"] = left_out_;
    out["mode_bytes"] = std::size_t{24} * body_.space().nodes() * options_.body.modal.modes;
    if (task_.problem.frequencies > 0)
      out["frequencies_hz"] =
          std::vector<double>(frequencies_.begin(),
                              frequencies_.begin() + static_cast<std::ptrdiff_t>(task_.problem.frequencies));
  }

  double kernel_s() const { return setup_s_ + stepping_s_; }
  bool is_finite() const { return is_finite_; }
  const MotionHistory& history() const { return history_; }
  const MotionStates& states() const { return states_; }

 private:
  void step_through(ModalPhase& moving, std::span<const LoadPhase> phases, std::size_t at) {
    const LoadPhase& phase = phases[at];
    const bool is_last = at + 1 == phases.size();
    const auto [steps, step_s] = plan_.phases[at];
    longest_step_s_ = std::max(longest_step_s_, step_s);
    const Stopwatch preparing;
    moving.prepare(step_s);
    setup_s_ += preparing.seconds();
    for (std::uint64_t k = 1; k <= steps; ++k) {
      const double time_s = k == steps ? phase.to_s : phase.from_s + static_cast<double>(k) * step_s;
      const Stopwatch stepping;
      moving.advance(step_s, time_s);
      stepping_s_ += stepping.seconds();
      ++steps_;
      if (steps_ % plan_.stride == 0 || (is_last && k == steps)) add_row(moving, phase, time_s);
    }
  }

  void add_row(const ModalPhase& moving, const LoadPhase& phase, double time_s) {
    const dynamics::ModalMeasure now = moving.measure();
    HistoryMoment moment{time_s, now.kinetic_j, now.elastic_j, now.load_j, now.group_force_n, {}};
    for (const Index probe : task_.problem.probes) moment.probe_m.push_back(moving.displacement_of(probe));
    std::vector<double> row = history_row(task_.problem, phase, moment);
    for (const double number : row) is_finite_ = is_finite_ && std::isfinite(number);
    history_.rows.push_back(std::move(row));
    if (!states_.is_due(time_s)) return;
    std::vector<Vec3> field = moving.state().displacement_m;
    field.resize(task_.mesh.points.size());  // behind the vertices lie the middles of edges
    states_.add(time_s, std::move(field));
  }

  const MotionTask& task_;
  const MovingOptions& options_;
  ModalBody body_;
  MotionHistory history_;
  MotionStates states_{task_.problem.duration_s, task_.mesh.points.size()};
  StepPlan plan_;
  std::uint64_t steps_ = 0;
  double longest_step_s_ = 0.0;
  double setup_s_ = 0.0;
  double stepping_s_ = 0.0;
  double left_out_ = 0.0;
  bool is_finite_ = true;
  std::vector<double> frequencies_;
};

}  // namespace

Response run_modal_at_rest(const Request& request) {
  require_method(request, "reduced.modal");
  json left = request.options;
  const ModalBodyOptions options = take_modal_options(left);
  const bool with_steps = take_option<bool>(left, "step_cost", &json::is_boolean, "true or false", false);
  require_all_taken(left);
  const DeformTask task = read_deform_task(request);
  refuse_large(task.problem.strain, request.method);
  dynamics::require_no_rigid_motion(task.mesh, dynamics::build_loads(task.mesh, task.problem));
  Response response;
  const Stopwatch start;
  const dynamics::ElementSpace space = dynamics::build_element_space(task.mesh, options.order);
  const dynamics::ElementMatrices body = build_element_matrices(task.mesh, space, task.problem.material);
  std::vector<ModalGroup> groups{
      {build_node_loads(task.mesh, space, task.problem, BodyForces::kInclude), {}}};
  ModalPhase modal(body, options.order, std::move(groups), options.modal, choose_factor(options.factor));
  const double setup_s = start.seconds();
  const Stopwatch solving;
  modal.rest();
  std::vector<Vec3> u = modal.state().displacement_m;
  response.kernel_s = start.seconds();
  const double solve_s = solving.seconds();
  const dynamics::ModalMeasure at_rest = modal.measure();
  u.resize(task.mesh.points.size() + space.edges.edges.size());
  response.report = {{"method", request.method},
                     {"outcome", "converged"},
                     {"energy_j", at_rest.elastic_j},
                     {"potential_j", at_rest.elastic_j + at_rest.load_j},
                     {"identify_s", setup_s},
                     {"solve_s", solve_s},
                     {"iterations", 1},
                     {"residual_relative", 0.0},
                     {"modes", options.modal.modes},
                     {"unknowns", 3 * space.nodes()}};
  if (with_steps) report_step_cost(modal, task.mesh.points.size(), response.report);
  write_displacement(request.output, u);
  return response;
}

Response run_modal_motion(const Request& request) {
  require_method(request, "moving_reduced.modal");
  json left = request.options;
  MovingOptions options;
  options.body = take_modal_options(left);
  options.time_step_s = take_number(left, "time_step_s", 1e-9, 1e6, options.time_step_s);
  require_all_taken(left);
  const MotionTask task = read_motion_task(request);
  refuse_large(task.problem.body.strain, request.method);
  Response response;
  response.report = {{"method", request.method},
                     {"integrator", "exponential"},
                     {"modes", options.body.modal.modes},
                     {"vertices", task.mesh.points.size()}};
  ModalMotion motion(task, options);
  const Stopwatch start;
  motion.run();
  response.kernel_s = std::min(motion.kernel_s(), start.seconds());
  motion.report(response);
  if (motion.is_finite()) {
    write_history(request.output, motion.history());
    motion.states().write_beside(request.output);
  }
  return response;
}

}  // namespace palpate::reference

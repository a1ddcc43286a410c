// reduced.modal_ticks and reduced.modal_replay.

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <string>
#include <vector>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/stopwatch.h"
#include "core/mesh/geometry.h"
#include "reference/door/moving_body.h"
#include "reference/door/request_options.h"
#include "reference/elastic_models/stepped_motion.h"
#include "reference/elastic_models/tick_report.h"
#include "reference/reduced/modal_body.h"
#include "reference/reduced/modal_run.h"

namespace palpate::reference {
namespace {

using nlohmann::json;

/// The finite elements and their modes.
struct ModalBodyOptions {
  int order = 2;
  std::string factor;
  dynamics::ModalOptions modal;
};

/// Takes them, and the mesh's vertices.
ModalBodyOptions take_body_options(json& left) {
  ModalBodyOptions options;
  options.order = take_choice(left, "elements", {"p2", "p1"}) == 0 ? 2 : 1;
  options.modal.modes = static_cast<std::size_t>(take_whole(left, "modes", 1, 1000, 60));
  options.modal.correction = take_option<bool>(left, "correction", &json::is_boolean, "true or false", true);
  const std::vector<std::string> factors{"auto", "cholmod", "eigen"};
  options.factor = factors[take_choice(left, "factor", factors)];
  take_mesh_vertices(left);
  return options;
}

void note_large(const MotionProblem& motion, const std::string& method, Response& response) {
  if (motion.body.strain == StrainSize::kLarge)
    response.notes.push_back(method + " is linear: large strains and rotations are taken for small ones");
}

/// The tool's force at the end of each tick; `clock` has their times. A force that is not finite is the last.
std::vector<Vec3> tick_through(dynamics::ModalPhase& body, std::size_t group, const TickLoop& loop,
                               TickClock& clock) {
  const std::uint64_t all = loop.warm_ticks + loop.ticks;
  std::vector<Vec3> force_n(all);
  clock.start();
  for (std::uint64_t k = 0; k < all; ++k) {
    body.advance(loop.tick_s, static_cast<double>(k + 1) * loop.tick_s);
    force_n[k] = body.group_force(group);
    if (!is_finite(force_n[k])) break;
    clock.end_tick();
  }
  force_n.resize(clock.ticks());
  return force_n;
}

/// A scene from start to end.
class ModalReplay {
 public:
  ModalReplay(const MovingTask& task, const ModalBodyOptions& options, double time_step_s)
      : mesh_(task.mesh),
        problem_(task.body.motion),
        modal_(options.modal),
        plan_(plan_steps(problem_, time_step_s, kMostModalSteps)),
        body_(task.mesh, problem_, options.order, options.factor),
        columns_(history_columns(problem_)) {
    columns_.insert(columns_.end(), {"largest_displacement_m", "rms_displacement_m", "largest_speed_m_s"});
    for (const PhaseSteps& phase : plan_.phases) all_steps_ += phase.steps;
    const std::uint64_t frames = task.body.stepping.frames;
    frame_stride_ = frames > 0 ? std::max<std::uint64_t>(1, all_steps_ / frames) : 0;
    setup_s_ = clock_.seconds();
  }

  void run() {
    const std::size_t nodes = body_.space().nodes();
    dynamics::NodeState state{std::vector<Vec3>(nodes), std::vector<Vec3>(nodes)};
    const std::vector<LoadPhase> phases = find_phases(problem_);
    for (std::size_t k = 0; k < phases.size() && is_finite_; ++k) {
      dynamics::ModalPhase& moving = phase_of(phases[k], plan_.phases[k].step_s);
      left_out_ = std::max(left_out_, moving.start(state, phases[k].from_s));
      if (k == 0) look(moving, phases[k], phases[k].from_s);
      step_through(moving, phases[k], plan_.phases[k]);
      state = moving.state();
    }
  }

  void report(Response& response) const {
    response.kernel_s = stepping_s_;
    response.report = {{"outcome", !is_finite_     ? "diverged"
                                   : inverted_ > 0 ? "inverted"
                                                   : "completed"},
                       {"kind", "replay"},
                       {"engine", "modes"},
                       {"integrator", "exponential"},
                       {"precision", "double"},
                       {"steps", steps_},
                       {"steps_planned", all_steps_},
                       {"time_step_s", longest_step()},
                       {"simulated_s", time_s_},
                       {"real_time_factor", time_s_ / stepping_s_},
                       {"setup_s", setup_s_},
                       {"holdings", made_.size()},
                       {"left_out_at_phases", left_out_},
                       {"modes", modal_.modes},
                       {"unknowns", 3 * body_.space().nodes()},
                       {"peak_speed_m_s", peak_speed_},
                       {"inverted_tets", inverted_},
                       {"inverted_tets_most", inverted_most_},
                       {"vertices", mesh_.points.size()},
                       {"tets", mesh_.tets.size()}};
  }

  json answer() const {
    return {{"schema", "palpate/engine/1"},
            {"kind", "replay"},
            {"columns", columns_},
            {"rows", rows_},
            {"frames", frames_}};
  }

 private:
  double longest_step() const {
    double most = 0.0;
    for (const PhaseSteps& phase : plan_.phases) most = std::max(most, phase.step_s);
    return most;
  }

  /// The modes of a holding, made once.
  dynamics::ModalPhase& phase_of(const LoadPhase& phase, double step_s) {
    const Stopwatch making;
    auto found = made_.find(phase.loads);
    if (found == made_.end()) found = made_.emplace(phase.loads, body_.build_phase(phase, modal_)).first;
    found->second.prepare(step_s);
    setup_s_ += making.seconds();
    return found->second;
  }

  void step_through(dynamics::ModalPhase& moving, const LoadPhase& phase, const PhaseSteps& plan) {
    for (std::uint64_t k = 1; k <= plan.steps && is_finite_; ++k) {
      time_s_ = k == plan.steps ? phase.to_s : phase.from_s + static_cast<double>(k) * plan.step_s;
      const Stopwatch stepping;
      moving.advance(plan.step_s, time_s_);
      stepping_s_ += stepping.seconds();
      ++steps_;
      if (steps_ % plan_.stride == 0 || steps_ == all_steps_) look(moving, phase, time_s_);
    }
  }

  /// A row, and a frame where it is due.
  void look(const dynamics::ModalPhase& moving, const LoadPhase& phase, double time_s) {
    const dynamics::ModalMeasure now = moving.measure();
    HistoryMoment moment{time_s, now.kinetic_j, now.elastic_j, now.load_j, now.group_force_n, {}};
    for (const Index probe : problem_.probes) moment.probe_m.push_back(moving.displacement_of(probe));
    std::vector<double> row = history_row(problem_, phase, moment);
    dynamics::NodeState state = moving.state();
    state.displacement_m.resize(mesh_.points.size());  // behind the vertices lie the middles of edges
    state.velocity_m_s.resize(mesh_.points.size());
    double largest_sq = 0.0;
    double sum_sq = 0.0;
    double speed_sq = 0.0;
    for (std::size_t v = 0; v < mesh_.points.size(); ++v) {
      largest_sq = std::max(largest_sq, length_sq(state.displacement_m[v]));
      sum_sq += length_sq(state.displacement_m[v]);
      speed_sq = std::max(speed_sq, length_sq(state.velocity_m_s[v]));
    }
    row.push_back(std::sqrt(largest_sq));
    row.push_back(std::sqrt(sum_sq / static_cast<double>(mesh_.points.size())));
    row.push_back(std::sqrt(speed_sq));
    for (const double number : row) is_finite_ = is_finite_ && std::isfinite(number);
    if (!is_finite_) return;
    peak_speed_ = std::max(peak_speed_, row.back());
    inverted_ = count_inverted(state.displacement_m);
    inverted_most_ = std::max(inverted_most_, inverted_);
    rows_.push_back(std::move(row));
    const bool is_due = frame_stride_ > 0 && (steps_ >= next_frame_ || steps_ == all_steps_);
    if (!is_due) return;
    next_frame_ += frame_stride_;
    json numbers = json::array();
    for (const Vec3& u : state.displacement_m) {
      for (const double x : {u.x, u.y, u.z}) numbers.push_back(std::round(1e9 * x) / 1e9);  // for pictures
    }
    frames_.push_back({{"time_s", time_s}, {"displacement_m", std::move(numbers)}});
  }

  std::size_t count_inverted(const std::vector<Vec3>& u) const {
    const auto at = [&](Index v) { return mesh_.points[v] + u[v]; };
    return static_cast<std::size_t>(std::count_if(mesh_.tets.begin(), mesh_.tets.end(), [&](const Tet& t) {
      return !(signed_volume(at(t[0]), at(t[1]), at(t[2]), at(t[3])) > 0.0);
    }));
  }

  Stopwatch clock_;
  const TetMesh& mesh_;
  const MotionProblem& problem_;
  dynamics::ModalOptions modal_;
  StepPlan plan_;
  ModalBody body_;
  std::vector<std::string> columns_;
  std::map<std::vector<std::size_t>, dynamics::ModalPhase> made_;
  std::uint64_t all_steps_ = 0;
  std::uint64_t steps_ = 0;
  std::uint64_t frame_stride_ = 0;
  std::uint64_t next_frame_ = 0;
  double setup_s_ = 0.0;
  double stepping_s_ = 0.0;
  double time_s_ = 0.0;
  double left_out_ = 0.0;
  double peak_speed_ = 0.0;
  std::size_t inverted_ = 0;
  std::size_t inverted_most_ = 0;
  bool is_finite_ = true;
  json rows_ = json::array();
  json frames_ = json::array();
};

}  // namespace

Response run_modal_replay(const Request& request) {
  json left = request.options;
  const double time_step_s = take_number(left, "time_step_s", 1e-9, 1e6, 1e-3);
  const ModalBodyOptions options = take_body_options(left);
  require_all_taken(left);
  const MovingTask task = read_moving_task(request);
  Response response;
  note_large(task.body.motion, request.method, response);
  ModalReplay replay(task, options, time_step_s);
  replay.run();
  replay.report(response);
  write_file_atomically(request.output, replay.answer().dump() + "\n");
  return response;
}

Response run_modal_ticks(const Request& request) {
  json left = request.options;
  const TickLoop loop = take_tick_loop(left);
  const ModalBodyOptions options = take_body_options(left);
  require_all_taken(left);
  MovingTask task = read_moving_task(request);
  MotionProblem& motion = task.body.motion;
  const std::size_t tool = find_only_tool(motion);
  Response response;
  note_large(motion, request.method, response);
  motion.duration_s = loop.tick_s;
  const std::vector<LoadPhase> phases = find_phases(motion);
  std::size_t group = 1;
  while (phases.front().loads[group - 1] != tool) ++group;

  const Stopwatch making;
  const ModalBody body(task.mesh, motion, options.order, options.factor);
  const std::size_t nodes = body.space().nodes();
  dynamics::ModalPhase modes = body.build_phase(phases.front(), options.modal);
  modes.start({std::vector<Vec3>(nodes), std::vector<Vec3>(nodes)}, 0.0);
  const double identify_s = making.seconds();
  modes.prepare(loop.tick_s);
  const double setup_s = making.seconds();

  TickClock clock(loop);
  const std::vector<Vec3> force_n = tick_through(modes, group, loop, clock);
  const bool diverged = clock.ticks() < loop.warm_ticks + loop.ticks;
  const std::vector<double> seconds = clock.seconds();
  response.kernel_s = std::accumulate(seconds.begin(), seconds.end(), 0.0);
  response.report = {{"outcome", diverged ? "diverged" : "completed"},
                     {"kind", "ticks"},
                     {"integrator", "exponential"},
                     {"precision", "double"},
                     {"steps_per_tick", 1},
                     {"tick_s", loop.tick_s},
                     {"time_step_s", loop.tick_s},
                     {"identify_s", identify_s},
                     {"setup_s", setup_s},
                     {"first_tick_s", clock.ticks() > 0 ? clock.seconds_of(0) : 0.0},
                     {"modes", options.modal.modes},
                     {"mode_bytes", std::size_t{24} * nodes * options.modal.modes},
                     {"unknowns", 3 * nodes},
                     {"engine_threads", 1},
                     {"vertices", task.mesh.points.size()}};
  if (!seconds.empty()) add_tick_times(seconds, loop.tick_s, response.report);
  write_file_atomically(request.output, describe_tick_forces(force_n, loop.tick_s, diverged).dump() + "\n");
  return response;
}

}  // namespace palpate::reference

#include "reference/lattices/moving_run.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/base/stopwatch.h"
#include "core/dynamics/motion/motion_forces.h"
#include "core/dynamics/stability/lowest_modes.h"
#include "core/dynamics/stability/stability.h"
#include "core/mesh/geometry.h"
#include "core/springs/lattice/lattice_network.h"
#include "reference/door/motion_problem.h"
#include "reference/door/request_options.h"
#include "reference/elastic_models/stepped_motion.h"
#include "reference/lattices/embedded_loads.h"
#include "reference/lattices/lattice_body.h"

namespace palpate::reference {
namespace {

using dynamics::BlockMatrix;
using dynamics::MotionModel;
using dynamics::MotionState;
using nlohmann::json;

/// Loads that follow one profile.
struct MovingGroup {
  EmbeddedLoads loads;
  dynamics::TimeProfile profile;
};

/// Group 0 holds the body, group k + 1 is time.loads[k].
struct LatticePhase {
  LoadPhase time;
  std::vector<MovingGroup> groups;
};

MotionModel build_motion(const LatticeBody& body, const MotionProblem& problem) {
  MotionModel model;
  model.elastic = body.elastic;
  model.mass_kg = build_lattice_masses(body.lattice, problem.body.material.density_kg_m3);
  set_damping({problem.damping_stiffness_s, problem.damping_mass_per_s}, model);
  return model;
}

/// A lattice that moves, phase by phase.
class LatticeMotion {
 public:
  LatticeMotion(const MotionTask& task, const LatticeBody& body, int threads)
      : task_(task),
        body_(body),
        model_(build_motion(body, task.problem)),
        forces_(model_, threads),
        history_{history_columns(task.problem), {}} {
    const std::vector<Vec3> rest(model_.mass_kg.size());
    BlockMatrix free = build_lattice_pattern(body);
    BlockMatrix damping = free;
    add_motion_stiffness(model_, rest, dynamics::TangentKind::kExact, free);
    add_changing_damping(model_, rest, damping);
    add_constant_damping(model_, damping);
    for (const LoadPhase& time : find_phases(task.problem)) {
      LatticePhase& phase = phases_.emplace_back(LatticePhase{time, {}});
      phase.groups.push_back({embed_loads(body, task.mesh, task.problem.body), {}});
      for (const std::size_t k : time.loads) {
        const MotionLoad& load = task.problem.loads[k];
        phase.groups.push_back({embed_loads(body, task.mesh, load.part), load.profile});
      }
      stiffness_ = free;
      for (const MovingGroup& group : phase.groups) add_load_stiffness(group.loads, stiffness_);
      const dynamics::StableStep stable = predict_stable_step(
          stiffness_, damping, model_.mass_kg, dynamics::IntegratorKind::kSymplecticEuler, threads);
      if (!stable.converged) throw UnavailableError("the stable step did not converge");
      stable_step_s_ = std::min(stable_step_s_, stable.step_s);
    }
  }

  /// The shortest of the phases' bounds.
  double stable_step_s() const { return stable_step_s_; }

  /// Of the last phase, in Hz.
  std::vector<double> find_frequencies() const {
    const std::vector<std::uint8_t> held(model_.mass_kg.size());
    const dynamics::NaturalModes modes =
        find_lowest_modes(stiffness_, model_.mass_kg, held, task_.problem.frequencies);
    if (!modes.converged) throw UnavailableError("the lowest frequencies did not converge");
    return modes.frequency_hz;
  }

  void run(double step_s) {
    constexpr double kMostSteps = 1e9;
    const StepPlan plan = plan_steps(task_.problem, step_s, kMostSteps);
    stride_ = plan.stride;
    const std::size_t n = model_.mass_kg.size();
    state_ = {0.0, std::vector<Vec3>(n), std::vector<Vec3>(n)};
    bound_m_ = kEscapeRatio * longest_side(bounding_box(body_.elastic.rest));
    add_row(phases_.front());
    for (std::size_t k = 0; k < phases_.size() && is_good_; ++k)
      run_phase(phases_[k], plan.phases[k], k + 1 == phases_.size());
  }

  void report(json& out) const {
    out["outcome"] = is_good_ ? "completed" : "diverged";
    out["steps"] = steps_;
    out["time_step_s"] = longest_step_s_;
  }

  bool is_good() const { return is_good_; }
  double watching_s() const { return watching_s_; }
  const MotionHistory& history() const { return history_; }
  const MotionStates& states() const { return states_; }

 private:
  static constexpr double kEscapeRatio = 1000.0;

  void run_phase(const LatticePhase& phase, const PhaseSteps& planned, bool is_last) {
    const auto [steps, h] = planned;
    longest_step_s_ = std::max(longest_step_s_, h);
    std::vector<Vec3> force(model_.mass_kg.size());
    for (std::uint64_t k = 1; k <= steps && is_good_; ++k) {
      forces_.evaluate(state_.displacement_m, state_.velocity_m_s, state_.time_s, force);
      for (const MovingGroup& group : phase.groups)
        add_load_forces(group.loads, state_.displacement_m, value_at(group.profile, state_.time_s).share,
                        force);
      for (std::size_t v = 0; v < force.size(); ++v) {
        state_.velocity_m_s[v] = state_.velocity_m_s[v] + (h / model_.mass_kg[v]) * force[v];
        state_.displacement_m[v] = state_.displacement_m[v] + h * state_.velocity_m_s[v];
      }
      state_.time_s = k == steps ? phase.time.to_s : phase.time.from_s + static_cast<double>(k) * h;
      ++steps_;
      if (steps_ % stride_ == 0 || k == steps) {
        const Stopwatch watching;
        check_state();
        if (steps_ % stride_ == 0 || is_last) add_row(phase);
        watching_s_ += watching.seconds();
      }
    }
  }

  void check_state() {
    is_good_ = std::all_of(state_.displacement_m.begin(), state_.displacement_m.end(),
                           [&](const Vec3& u) { return is_finite(u) && length(u) <= bound_m_; });
  }

  void add_row(const LatticePhase& phase) {
    if (!is_good_) return;
    const dynamics::MotionEnergy energy = measure_energy(model_, state_);
    HistoryMoment moment{state_.time_s, energy.kinetic_j, energy.elastic_j, 0.0, {}, {}};
    for (const MovingGroup& group : phase.groups) {
      const double share = value_at(group.profile, state_.time_s).share;
      moment.load_j += load_energy(group.loads, state_.displacement_m, share);
      moment.push_n.push_back(total_force(group.loads, state_.displacement_m, share));
    }
    moment.probe_m = interpolate(probes_, state_.displacement_m);
    history_.rows.push_back(history_row(task_.problem, phase.time, moment));
    if (states_.is_due(state_.time_s))
      states_.add(state_.time_s, interpolate(body_.vertices, state_.displacement_m));
  }

  springs::Embedding embed_probes() const {
    std::vector<Vec3> places;
    for (const Index probe : task_.problem.probes) places.push_back(task_.mesh.points[probe]);
    return build_embedding(body_.lattice, places);
  }

  const MotionTask& task_;
  const LatticeBody& body_;
  MotionModel model_;
  dynamics::MotionForces forces_;
  MotionHistory history_;
  MotionStates states_{task_.problem.duration_s, task_.mesh.points.size()};
  springs::Embedding probes_ = embed_probes();
  std::vector<LatticePhase> phases_;
  double stable_step_s_ = std::numeric_limits<double>::infinity();
  BlockMatrix stiffness_;  ///< of the last phase, supports included
  MotionState state_;
  double bound_m_ = 0.0;
  std::uint64_t stride_ = 1;
  std::uint64_t steps_ = 0;
  double longest_step_s_ = 0.0;
  double watching_s_ = 0.0;
  bool is_good_ = true;
};

}  // namespace

Response run_moving_lattice(const Request& request) {
  const MotionTask task = read_motion_task(request);
  json left = request.options;
  const LatticeRequest wanted = take_lattice_request("moving_lattice.", request.method, left);
  const StepRequest stepping = take_step_request(left);
  require_all_taken(left);

  Response response;
  json& report = response.report;
  const Stopwatch kernel;
  const LatticeBody body = build_lattice_body(task.mesh, task.problem.body, wanted);
  const double identify_s = kernel.seconds();
  LatticeMotion motion(task, body, request.threads);
  const double stable_step_s = motion.stable_step_s();
  const double step_s = choose_time_step(stepping, "symplectic_euler", stable_step_s);
  const double setup_s = kernel.seconds() - identify_s;
  const Stopwatch solving;
  motion.run(step_s);
  const double solve_s = solving.seconds() - motion.watching_s();
  response.kernel_s = kernel.seconds() - motion.watching_s();

  report = {{"method", request.method},
            {"integrator", "symplectic_euler"},
            {"vertices", task.mesh.points.size()},
            {"identify_s", identify_s},
            {"setup_s", setup_s},
            {"solve_s", solve_s},
            {"stable_step_s", stable_step_s}};
  motion.report(report);
  report_lattice(body, report);
  if (const std::string note = material_note(task.problem.body.material, wanted); !note.empty())
    response.notes.push_back(note);
  if (task.problem.frequencies > 0) report["frequencies_hz"] = motion.find_frequencies();
  if (motion.is_good()) {
    write_history(request.output, motion.history());
    motion.states().write_beside(request.output);
  }
  return response;
}

}  // namespace palpate::reference

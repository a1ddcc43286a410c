#include "reference/engine/motion_replay.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>

#include "core/base/stopwatch.h"
#include "core/dynamics/time_loop/plain_run.h"
#include "reference/door/json_file.h"
#include "reference/elastic_models/stepped_motion.h"

namespace palpate::reference {
namespace {

using dynamics::MotionOutcome;
using dynamics::MotionReport;
using dynamics::MotionState;
using nlohmann::json;

json energy_json(const dynamics::MotionEnergy& energy) {
  return {{"kinetic_j", number_or_null(energy.kinetic_j)},
          {"elastic_j", number_or_null(energy.elastic_j)},
          {"load_j", number_or_null(energy.load_j)}};
}

/// Runs the phases one after the other.
class MotionRunner {
 public:
  MotionRunner(const MovingBody& body, const MotionSetup& setup, MotionOutput& output,
               const MotionStops& stops)
      : setup_(setup),
        output_(output),
        strides_(body.motion.samples, body.stepping.frames, setup.steps),
        stops_(stops) {}

  void run() {
    state_ = start_at_rest(setup_.phases.front().model);
    start_energy_ = measure_energy(setup_.phases.front().model, state_);
    for (const MotionPhase& phase : setup_.phases) {
      run_phase(phase);
      last_ = &phase;
      if (report_.outcome == MotionOutcome::kDiverged || report_.outcome == MotionOutcome::kStopped) break;
    }
    if (strides_.frame > 0 && report_.is_finite) output_.add_frame(state_);
  }

  json report() const {
    const double kernel_s = watch_.seconds() - watching_s_;
    double farthest = 0.0;
    for (const Vec3& u : state_.displacement_m) farthest = std::max(farthest, length(u));
    std::array<char, 32> hash{};
    std::snprintf(hash.data(), hash.size(), "fnv1a:%016llx",
                  static_cast<unsigned long long>(report_.state_hash));
    json out{{"outcome", outcome()},
             {"steps", report_.steps},
             {"steps_planned", setup_.steps},
             {"kernel_s", kernel_s},
             {"simulated_s", state_.time_s},
             {"real_time_factor", number_or_null(state_.time_s / kernel_s)},
             {"max_displacement_m", output_.files().max_displacement_m()},
             {"end_displacement_m", number_or_null(farthest)},
             {"peak_speed_m_s", report_.peak_speed_m_s},
             {"zero_length_springs", report_.zero_length_springs},
             {"speeds_cut", report_.speeds_cut},
             {"steps_with_speeds_cut", report_.steps_with_cuts},
             {"solver_iterations", report_.solver_iterations},
             {"steps_unsolved", report_.steps_unsolved},
             {"residual_worst", report_.residual_worst ? json(*report_.residual_worst) : json(nullptr)},
             {"frozen_vertices", setup_.frozen.size()},
             {"frozen_force_most_n",
              setup_.frozen.empty() ? json(nullptr) : number_or_null(output_.max_frozen_force_n())},
             {"inverted_tets", report_.inverted_tets},
             {"inverted_tets_most", report_.inverted_tets_most},
             {"first_inversion_s",
              report_.first_inversion_s < 0.0 ? json(nullptr) : json(report_.first_inversion_s)},
             {"state_is_finite", report_.is_finite},
             {"first_bad_vertex",
              report_.first_bad_vertex == kNoIndex ? json(nullptr) : json(report_.first_bad_vertex)},
             {"energy_start", energy_json(start_energy_)},
             {"state_hash", hash.data()}};
    out["energy_end"] = report_.is_finite ? energy_json(measure_energy(last_->model, state_)) : json(nullptr);
    add_rounding_gain(out);
    return out;
  }

 private:
  const char* outcome() const {
    if (report_.outcome == MotionOutcome::kStopped) return is_interrupted_ ? "interrupted" : "timed_out";
    return motion_outcome_name(report_.outcome);
  }

  void add_rounding_gain(json& out) const {
    out["rounding_gain_j"] = out["rounding_gain_over_kinetic"] = nullptr;
    if (!setup_.single_precision || setup_.engine != EngineChoice::kPlain) return;
    const double gain =
        static_cast<double>(report_.steps) * dynamics::rounding_gain_per_step(setup_.phases.front().model);
    out["rounding_gain_j"] = number_or_null(gain);
    out["rounding_gain_over_kinetic"] = number_or_null(gain / output_.files().max_kinetic_j());
  }

  bool should_stop() {
    is_interrupted_ = stops_.stop_flag != nullptr && *stops_.stop_flag != 0;
    return is_interrupted_ || watch_.seconds() > stops_.timeout_s;
  }

  void run_phase(const MotionPhase& phase) {
    std::optional<dynamics::Integrator> integrator;
    std::optional<dynamics::MotionForces> own_forces;
    if (setup_.engine != EngineChoice::kGeneral) {
      own_forces.emplace(phase.model, setup_.integrator.threads);
    } else {
      integrator.emplace(phase.model, setup_.integrator);
    }
    dynamics::MotionForces& forces = integrator ? integrator->forces() : *own_forces;
    forces.impose(state_.time_s, state_.displacement_m, state_.velocity_m_s);
    const std::uint64_t done = report_.steps;
    const auto observe = [&](std::uint64_t step, const MotionState& state) {
      const Stopwatch watching;
      // The state that a phase begins with is the last one of the phase before; a short one may have no step.
      if (step > 0 || !has_row_) output_.add_row(phase, forces, state);
      has_row_ = true;
      if (stops_.progress != nullptr) stops_.progress->reach(done + step);
      const bool is_due = strides_.frame > 0 && done + step >= next_frame_;
      if (is_due || (strides_.frame > 0 && done + step == setup_.steps)) {
        output_.add_frame(state);
        next_frame_ += strides_.frame;
      }
      watching_s_ += watching.seconds();
    };
    dynamics::MotionRunOptions options;
    options.step_s = setup_.step_s;
    options.steps = phase.last_step - done;
    options.observe_every = strides_.row;
    options.should_stop = [this] { return should_stop(); };
    if (integrator) {
      add_phase(run_motion(*integrator, state_, options, observe), report_);
    } else {
      const dynamics::PlainRunOptions own{options, setup_.integrator.threads,
                                          setup_.integrator.speed_limit_m_s, setup_.single_precision};
      add_phase(setup_.engine == EngineChoice::kTets ? run_tet_motion(phase.model, state_, own, observe)
                                                     : run_plain_motion(phase.model, state_, own, observe),
                report_);
    }
  }

  const MotionSetup& setup_;
  MotionOutput& output_;
  Strides strides_;
  MotionStops stops_;
  Stopwatch watch_;
  double watching_s_ = 0.0;  ///< spent on rows and frames
  MotionState state_;
  dynamics::MotionEnergy start_energy_;
  MotionReport report_;
  const MotionPhase* last_ = nullptr;  ///< in which the run ended
  bool is_interrupted_ = false;
  bool has_row_ = false;
  std::uint64_t next_frame_ = 0;
};

}  // namespace

json run_motion_setup(const MovingBody& body, const TetMesh& mesh, const MotionSetup& setup,
                      const MotionStops& stops, MotionOutput& output) {
  MotionRunner runner(body, setup, output, stops);
  runner.run();
  json summary = runner.report();
  summary["method"] = setup.method;
  summary["integrator"] = dynamics::integrator_name(setup.integrator.kind);
  summary["engine"] = engine_name(setup.engine);
  summary["precision"] = setup.single_precision ? "single" : "double";
  summary["why_general"] = setup.why_general.empty() ? json(nullptr) : json(setup.why_general);
  summary["time_step_s"] = setup.step_s;
  summary["stable_step_s"] = number_or_null(setup.stable.step_s);
  summary["stable_by"] = setup.stable_by;
  summary["stability_margin"] = number_or_null(setup.stable.step_s / setup.step_s);
  summary["speed_limit_m_s"] =
      setup.integrator.speed_limit_m_s > 0.0 ? json(setup.integrator.speed_limit_m_s) : json(nullptr);
  summary["threads"] = setup.integrator.threads;
  summary["vertices"] = mesh.points.size();
  summary["tets"] = mesh.tets.size();
  summary["springs"] = setup.phases.front().model.elastic.springs.springs.size();
  summary["laws"] = list_laws(setup.phases.front().model.elastic);
  summary["model"] = setup.report;
  return summary;
}

}  // namespace palpate::reference

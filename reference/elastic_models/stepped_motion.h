// A body that is stepped through the phases of a motion: how many steps, how long they are, how it is damped,
// and what happened.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/dynamics/motion/motion_model.h"
#include "core/dynamics/time_loop/motion_run.h"
#include "reference/door/motion_problem.h"

namespace palpate::reference {

/// Whole steps of one length that fill a phase.
struct PhaseSteps {
  std::uint64_t steps = 0;
  double step_s = 0.0;
};

/// How the phases of a problem are stepped.
struct StepPlan {
  std::vector<PhaseSteps> phases;  ///< one a phase of find_phases
  std::uint64_t stride = 1;  ///< steps from one row of the history to the next: at most `samples` in all
};

/// The fewest steps of at most `time_step_s` in each phase. Throws: InputError for more than `most` in all.
StepPlan plan_steps(const MotionProblem& problem, double time_step_s, double most);

/// The step that a request asks for: its own, or 0 for `safety` times the bound.
struct StepRequest {
  double time_step_s = 0.0;
  double safety = 0.9;
};

/// Takes `time_step_s` and `safety` out of `options`. Throws: InputError for what is no such number.
StepRequest take_step_request(nlohmann::json& options);

/// The step, in s. Throws: InputError for one over the bound of `integrator`, and for none where there is no
/// bound (infinity) or no stable step (0).
double choose_time_step(const StepRequest& wanted, const std::string& integrator, double stable_step_s);

/// Damping by shares of stiffness and mass, and by constants beside them.
struct DampingShares {
  double stiffness_s = 0.0;       ///< of each spring's stiffness and of the strain terms' moduli
  double mass_per_s = 0.0;        ///< of each vertex's mass
  double spring_n_s_per_m = 0.0;  ///< of each spring
  double vertex_n_s_per_m = 0.0;  ///< of each vertex
};

/// Damps a model that has its springs and masses; what no share and no constant damps stays without.
void set_damping(const DampingShares& shares, dynamics::MotionModel& model);

/// Adds what happened in a phase to what happened in those before it, `all`: counts are summed, worsts kept,
/// and the end is named anew.
void add_phase(const dynamics::MotionReport& phase, dynamics::MotionReport& all);

}  // namespace palpate::reference

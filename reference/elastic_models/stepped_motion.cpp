#include "reference/elastic_models/stepped_motion.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/base/error.h"
#include "reference/door/request_options.h"

namespace palpate::reference {

using dynamics::MotionOutcome;
using dynamics::MotionReport;
using nlohmann::json;

StepPlan plan_steps(const MotionProblem& problem, double time_step_s, double most) {
  constexpr double kRounding = 1e-12;  // a step that fills a phase to rounding is not two
  std::vector<double> lengths_s;
  std::vector<double> counts;
  for (const LoadPhase& phase : find_phases(problem)) {
    lengths_s.push_back(phase.to_s - phase.from_s);
    counts.push_back(std::ceil(lengths_s.back() / time_step_s * (1.0 - kRounding)));
  }
  const double steps = std::accumulate(counts.begin(), counts.end(), 0.0);
  if (!(steps <= most))
    throw InputError("time_step_s", 0,
                     "at most 1e" + std::to_string(std::lround(std::log10(most))) + " steps",
                     json(steps).dump());
  StepPlan plan;
  plan.stride =
      static_cast<std::uint64_t>(std::ceil(steps / static_cast<double>(problem.samples) * (1.0 - kRounding)));
  for (std::size_t k = 0; k < counts.size(); ++k)
    plan.phases.push_back({static_cast<std::uint64_t>(counts[k]), lengths_s[k] / counts[k]});
  return plan;
}

StepRequest take_step_request(json& options) {
  StepRequest wanted;
  wanted.time_step_s = take_number(options, "time_step_s", 0.0, 1e6, wanted.time_step_s);
  wanted.safety = take_number(options, "safety", 1e-6, 1.0, wanted.safety);
  return wanted;
}

double choose_time_step(const StepRequest& wanted, const std::string& integrator, double stable_step_s) {
  const auto fail = [](const std::string& expected, const std::string& found) {
    throw InputError("time_step_s", 0, expected, found);
  };
  if (wanted.time_step_s > stable_step_s)
    fail("at most the stable step of " + integrator + ", " + json(stable_step_s).dump(),
         json(wanted.time_step_s).dump());
  if (wanted.time_step_s > 0.0) return wanted.time_step_s;
  if (!std::isfinite(stable_step_s))
    fail("a number of seconds for " + integrator + ", which has no bound", "0");
  if (!(stable_step_s > 0.0)) fail("a stable step of " + integrator, "none");
  return wanted.safety * stable_step_s;
}

void set_damping(const DampingShares& shares, dynamics::MotionModel& model) {
  model.strain_damping_s = shares.stiffness_s;
  model.spring_damping_n_s_per_m.clear();
  if (shares.stiffness_s > 0.0 || shares.spring_n_s_per_m > 0.0) {
    for (const double stiffness : model.elastic.springs.stiffness_n_per_m)
      model.spring_damping_n_s_per_m.push_back(shares.stiffness_s * stiffness + shares.spring_n_s_per_m);
  }
  model.environment_damping_n_s_per_m.clear();
  if (shares.mass_per_s > 0.0 || shares.vertex_n_s_per_m > 0.0) {
    for (const double mass : model.mass_kg)
      model.environment_damping_n_s_per_m.push_back(shares.mass_per_s * mass + shares.vertex_n_s_per_m);
  }
}

void add_phase(const MotionReport& phase, MotionReport& all) {
  MotionReport sum = phase;
  sum.steps += all.steps;
  sum.zero_length_springs += all.zero_length_springs;
  sum.speeds_cut += all.speeds_cut;
  sum.steps_with_cuts += all.steps_with_cuts;
  sum.solver_iterations += all.solver_iterations;
  sum.steps_unsolved += all.steps_unsolved;
  if (all.residual_worst)
    sum.residual_worst = std::max(sum.residual_worst.value_or(0.0), *all.residual_worst);
  sum.peak_speed_m_s = std::max(sum.peak_speed_m_s, all.peak_speed_m_s);
  sum.inverted_tets_most = std::max(sum.inverted_tets_most, all.inverted_tets_most);
  if (all.first_inversion_s >= 0.0) sum.first_inversion_s = all.first_inversion_s;
  sum.outcome =
      name_end(sum, phase.outcome != MotionOutcome::kDiverged, phase.outcome == MotionOutcome::kStopped);
  all = sum;
}

}  // namespace palpate::reference

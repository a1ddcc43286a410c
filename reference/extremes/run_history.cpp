#include "reference/extremes/run_history.h"

namespace palpate::reference {

using nlohmann::json;

// Numbers that are not finite become null: JSON has no others.

json describe_run(const dynamics::WatchOptions& watch, const dynamics::WatchedRun& run,
                  dynamics::BodyStepper& stepper) {
  json rows = json::array();
  for (const dynamics::WatchedRow& row : run.rows) {
    rows.push_back({row.step, static_cast<double>(row.step) * watch.step_s, row.energy.kinetic_j,
                    row.energy.elastic_j, row.energy.load_j, row.most_kinetic_j, row.most_total_j,
                    row.least_total_j, row.farthest_m, row.inverted, row.is_finite, row.unsolved});
  }
  json displacement = json::array();
  for (const Vec3& u : stepper.state().displacement_m) displacement.push_back({u.x, u.y, u.z});
  return {{"step_s", watch.step_s},
          {"steps", watch.steps},
          {"says_growing", watch.is_known_to_grow},
          {"rows", std::move(rows)},
          {"displacement_m", std::move(displacement)}};
}

json describe_trial(double step_s, bool is_linear, const dynamics::MeasuredTrial& trial) {
  json stretches = json::array();
  for (const dynamics::TrialStretch& stretch : trial.stretches)
    stretches.push_back({stretch.until, stretch.mean_kinetic_j, stretch.most_kinetic_j});
  return {{"step_s", step_s},
          {"linear", is_linear},
          {"start_j", trial.start_j},
          {"stretches", std::move(stretches)}};
}

}  // namespace palpate::reference

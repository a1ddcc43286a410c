#include "experiments/fit/fit_motions.h"

#include <algorithm>
#include <iterator>

#include "experiments/trials/modal_stepping.h"
#include "experiments/trials/motion_stepping.h"
#include "experiments/trials/motion_trial.h"

namespace palpate::experiments {
namespace {

constexpr double kMotionShare = 0.6;  ///< of the time that is left, for the motion of another finalist
constexpr double kModalShare = 0.5;   ///< ... for that of modes: others wait
constexpr double kRestShare = 0.1;    ///< of the time limit: no other one's is begun with less

std::vector<FitStepping> steppings_of(const std::vector<FitStepping>& all, bool modes) {
  std::vector<FitStepping> own;
  std::copy_if(all.begin(), all.end(), std::back_inserter(own),
               [&](const FitStepping& stepping) { return stepping.modes.has_value() == modes; });
  return own;
}

}  // namespace

bool step_motions(const MotionSearch& search, const FitPlan& check, const Registry& registry,
                  Progress& progress, std::vector<FitPoint>& points) {
  bool is_complete = true;
  bool is_first = true;
  for (const FitPoint* good : choose_cheapest(points, search.require)) {
    FitPoint& point = points[static_cast<std::size_t>(good - points.data())];
    const double left_s = search.left_s();
    if (left_s <= (is_first ? 0.0 : kRestShare * search.time_limit_s)) {
      point.failure = "its motion was not run: no time was left";
      is_complete = false;
      continue;
    }
    progress.show_long("motion of " + point.candidate.name());
    SteppingTask task;
    task.scene = build_fitted_scene(search.placed, point.candidate.model,
                                    whole_mesh_of(point.candidate, check.folder / "run"));
    task.mesh = check.folder / "run" / "problems" / point.mesh / "in.mesh";
    task.probes_m = choose_probes(search.scene, task.mesh, kTrialProbes);
    task.most_error = search.require.at_most - point.worst_error();
    const bool of_modes = is_modal(point.candidate);
    task.time_limit_s = of_modes ? kModalShare * left_s : is_first ? left_s : kMotionShare * left_s;
    task.folder = check.folder / "motion" / plan_label(point.candidate);
    task.memory_bytes = search.require.memory_bytes;
    task.stop_flag = search.stop_flag;
    const std::vector<FitStepping> steppings = steppings_of(search.steppings, of_modes);
    point.steppings =
        of_modes ? try_modes(task, steppings, registry) : try_steppings(task, steppings, registry);
    is_first = is_first && of_modes;
    if (const SteppingTry* best = choose_stepping(point.steppings)) {
      point.stepping = *best;
      point.memory_bytes = std::max(point.memory_bytes, best->memory_bytes);
    } else {
      const SteppingTry& last = of_modes ? point.steppings.back() : point.steppings.front();
      point.failure = "no step leaves so little of its motion: " + last.stepping.label + " " + last.why_not;
    }
  }
  return is_complete;
}

}  // namespace palpate::experiments

// The motions of a fit's finalists: which integrator steps each the cheapest, within what the tolerance
// leaves.
#pragma once

#include <csignal>
#include <functional>
#include <vector>

#include "experiments/fit/candidates/fit_points.h"
#include "experiments/text/terminal.h"
#include "experiments/trials/fit_stepping.h"

namespace palpate::experiments {

/// A scene that moves, and how long its finalists may be looked at.
struct MotionSearch {
  const Scene& scene;
  Scene placed;                               ///< on its own mesh (place_scene)
  const std::vector<FitStepping>& steppings;  ///< to try; those with modes on models of modes
  SceneRequirement require;                   ///< the tolerance, without the budget
  double time_limit_s = 300.0;                ///< of the whole fit
  std::function<double()> left_s;             ///< of that
  const volatile std::sig_atomic_t* stop_flag = nullptr;
};

/// Tries the integrators on the motion of those points of a check that meet the tolerance at rest, the
/// cheapest first; what the best of them costs and leaves is the point's then.
///
/// Returns: false if the time was up before all were looked at; their `failure` says so.
/// Throws: as try_steppings.
bool step_motions(const MotionSearch& search, const FitPlan& check, const Registry& registry,
                  Progress& progress, std::vector<FitPoint>& points);

}  // namespace palpate::experiments

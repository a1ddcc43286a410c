// The last saving of a fit: a part of the body that hardly moves, held at rest.
#pragma once

#include <csignal>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "experiments/fit/candidates/fit_points.h"
#include "experiments/trials/frozen_choice.h"

namespace palpate::experiments {

/// A choice whose motion was verified, and how to look at it again.
struct FreezeTask {
  FitPlan check;                 ///< scene and other loads, as the choice was verified on
  nlohmann::json scene;          ///< the fitted scene with its stepping
  nlohmann::json probes_m;       ///< where motions are held against each other
  std::filesystem::path folder;  ///< is made
  double at_most = 0.0;          ///< the tolerance
  std::string measure;           ///< of the error at rest
  double time_limit_s = 100.0;   ///< of the clock, for all of it
  const volatile std::sig_atomic_t* stop_flag = nullptr;
  std::function<void(const FitPlan&, double seconds)> run;  ///< runs a plan as the fit does
};

/// Holds what moves by at most kFreezeShares of the tolerance times the rms displacement of the scene at
/// rest, the largest share first, and looks at it as at any candidate: at rest on the scene and on the loads
/// that the choice never saw, and in the scene's own motion against the whole model's. The first that keeps
/// the tolerance with all errors added, and is cheaper by the medians of three runs of each in turn, changes
/// `choice`: its model gets the option `frozen`, errors and costs are those of the held part, and
/// `frozen.json` in the folder has the vertices with the most force that the held part was verified with.
///
/// Returns: what was tried, with the reason why it was not taken. Throws: as run_plan and simulate.
std::vector<FrozenTry> freeze_still_part(const FreezeTask& task, const Registry& registry, FitPoint& choice);

}  // namespace palpate::experiments

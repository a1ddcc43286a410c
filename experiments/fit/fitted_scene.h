// A scene with the mesh and the model that a fit gives it.
#pragma once

#include <nlohmann/json.hpp>

#include "experiments/fit/fit_candidates.h"
#include "experiments/scene_reader/scene.h"

namespace palpate::experiments {

/// The scene with the model and `organ.mesh` (metres) beside it. Regions are in metres: they stay where the
/// scene's own mesh had them. `placed` is the scene on that (place_scene).
nlohmann::json build_fitted_scene(const Scene& placed, const FitModel& model);

}  // namespace palpate::experiments

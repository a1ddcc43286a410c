// What a live page starts with: the scene's own model where it can move, and the springs of every level.
#pragma once

#include "experiments/live/live_body.h"
#include "experiments/registry/registry.h"
#include "experiments/scene_reader/scene.h"

namespace palpate::experiments {

/// Sets start, spring_source and the springs of all levels from the scene's model: the method and options
/// that `simulate` would take. Linear finite elements start as linear tetrahedra, quadratic ones and
/// reduced.compliance as the table, which is to be made before. What cannot move live (trained springs, the
/// others of reduced) becomes a note, and springs by isotropy_patch and smoothed elements are there all the
/// same. Throws: InputError for an unknown model, and as identify_springs.
void choose_start(const Scene& scene, const Registry& registry, LiveBodyData& out);

}  // namespace palpate::experiments

// The modes of a fit on the fitted scene's own motion: how many of them do, held against the same finite
// elements stepped whole.
#pragma once

#include <string>
#include <vector>

#include "experiments/scene_reader/scene.h"
#include "experiments/trials/motion_stepping.h"

namespace palpate::experiments {

/// The method of the contest motion that steps the finite elements of a scene's modes whole: "moving_fem.p2"
/// or "moving_fem.p1". `model` is that of the scene, {reduced: modal, elements: p2}.
std::string whole_method(const nlohmann::json& model);

/// What a scene's motion has to be for its modes to be tried, or why they are not; empty if they are.
std::string why_no_modes(const Scene& scene, const std::vector<FitStepping>& steppings,
                         const nlohmann::json& model_set, const Registry& registry);

/// Tries each number of modes on the motion, the fewest first, until one holds. The motion is that of the
/// same elements on the same mesh, v, which another program steps whole (whole_method, Newmark's average
/// acceleration): in steps of a hundredth and a two-hundredth of the duration, and halves of that until what
/// they leave, |v_2h - v_h| / 3, is a quarter of `most_error` or the time does not allow a further one. What
/// modes leave of the motion is bounded by
///
///   |u - v_h| + |v_2h - v_h| / 3,
///
/// relative to v_h, over the whole time and all probes, u in steps of h too. Costs are those of three further
/// runs through the motion, with sixty displacements of all vertices a simulated second; what the modes take
/// to be found is `setup_s`, apart.
///
/// Returns: one a stepping, in their order. Throws: as simulate, but for what modes cannot take.
std::vector<SteppingTry> try_modes(const SteppingTask& task, const std::vector<FitStepping>& steppings,
                                   const Registry& registry);

}  // namespace palpate::experiments

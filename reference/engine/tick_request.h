// engine.ticks: the loop of a haptic device on whatever model, law and integrator a scene has.
#pragma once

#include <nlohmann/json.hpp>

#include "reference/door/adapter.h"
#include "reference/door/moving_body.h"

namespace palpate::reference {

/// Answers engine.ticks; `left` holds the options that nobody took yet.
///
/// The body, its engine and its integrator are those of engine.replay. A tick takes the fewest explicit steps
/// that the scene's safety allows, whatever step the scene gives; of integrators without a bound it takes the
/// fewest of at most the scene's step. `steps_per_tick` above 0 takes so many.
///
/// The report has, beside ticks and their times: engine, integrator, laws (of strain energies) and precision;
/// setup_s, from the task being read to the first tick, of which identify_s to make the model, its loads and
/// its bound; first_tick_s, in which implicit integrators factor; inverted_tets at the end, and of
/// integrators that iterate solver_iterations, steps_unsolved and residual_worst. Its outcome is "completed",
/// "unsolved", "inverted" or "diverged".
///
/// Throws: InputError for loads that come or go, another number of tools than one, precision "single" where
/// the general engine has to step, and as build_motion.
Response answer_ticks(MovingTask task, const Request& request, nlohmann::json& left);

}  // namespace palpate::reference

// moving_springs.* and moving_smoothed.*: a request of the contest motion.
#pragma once

#include "reference/door/adapter.h"

namespace palpate::reference {

/// Answers a request of our own springs and smoothed elements in motion.
///
/// The report holds outcome ("completed", "inverted", "diverged"), integrator, time_step_s (the longest
/// taken), stable_step_s (null for the implicit ones), steps, identify_s, setup_s (masses, damping, the
/// stable step), solve_s (the steps alone) and the frequencies that are asked for. Throws: InputError for a
/// bad request, or a time step over the predicted bound.
Response run_motion_request(const Request& request);

}  // namespace palpate::reference

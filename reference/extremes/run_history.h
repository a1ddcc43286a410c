// What the contest stability asks of a run beside its report: the histories by which the judge decides how it
// ended.
#pragma once

#include <nlohmann/json.hpp>

#include "core/dynamics/stability/measured_step.h"
#include "core/dynamics/time_loop/body_stepper.h"
#include "core/dynamics/time_loop/motion_outcome.h"

namespace palpate::reference {

/// A run as the answer's file has it (reference/PROTOCOL.md, palpate/stability_answer/1): its rows, and the
/// body as the stepper left it.
nlohmann::json describe_run(const dynamics::WatchOptions& watch, const dynamics::WatchedRun& run,
                            dynamics::BodyStepper& stepper);

/// A trial about rest, alike.
nlohmann::json describe_trial(double step_s, bool is_linear, const dynamics::MeasuredTrial& trial);

}  // namespace palpate::reference

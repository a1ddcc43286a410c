// A body that is moved by its lowest modes, as the watchers of the contest stability see it.
#pragma once

#include <cstddef>
#include <memory>

#include "core/dynamics/time_loop/body_stepper.h"
#include "reference/door/stability_problem.h"

namespace palpate::reference {

/// Steps the `modes` lowest modes of linear tetrahedra with the model's lumped masses, each step by its
/// exponential (core/dynamics/reduced/modal_phase.h). A state that is set is projected on them.
///
/// Throws: InputError for a model that is not of linear tetrahedra at small strain, for another damping than
/// Rayleigh's, damping by mass where masses have factors that differ, and a body that nothing holds.
/// `model` and `task` must outlive it.
std::unique_ptr<dynamics::BodyStepper> make_modal_stepper(const dynamics::MotionModel& model,
                                                          const StabilityTask& task, std::size_t modes);

}  // namespace palpate::reference

// What a simulated second by modes costs.
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>

#include "core/dynamics/reduced/modal_phase.h"

namespace palpate::reference {

/// No step of modes is too long, so that what is counted has to be said: steps of a millisecond, as the loop
/// of a haptic device asks for them.
inline constexpr double kCountedStepS = 1e-3;
/// The state of modes is a number a mode; where the vertices are is a product of its own, which is counted as
/// often as pictures are shown.
inline constexpr double kPicturesPerS = 60.0;

/// Seconds that the displacement of the first `nodes` takes: the median of nine.
double time_field(const dynamics::ModalPhase& body, std::size_t nodes);

/// Adds step_wall_s (the median of nine runs of some 10 ms), field_wall_s, step_engine ("modes") and
/// simulated_second_s = step_wall_s / kCountedStepS + kPicturesPerS x field_wall_s for a body under its
/// loads, which is stepped. What the modes take to be found is not in it. Times of a body that left the
/// finite numbers are null.
void report_step_cost(dynamics::ModalPhase& body, std::size_t nodes, nlohmann::json& report);

}  // namespace palpate::reference

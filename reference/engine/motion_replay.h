// Runs what is set up: the phases of a motion one after the other, with rows and frames on the way.
#pragma once

#include <csignal>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>

#include "reference/engine/motion_output.h"
#include "reference/engine/motion_progress.h"
#include "reference/engine/motion_setup.h"

namespace palpate::reference {

/// What ends a run before its time. It is looked at before each step; the plain engine and the tet engine
/// take steps for up to some 10 ms in between.
struct MotionStops {
  double timeout_s = std::numeric_limits<double>::infinity();
  const volatile std::sig_atomic_t* stop_flag = nullptr;  ///< ends it when it turns non-zero; may be null
  MotionProgress* progress = nullptr;                     ///< told at each row of the history; may be null
};

/// Runs a setup of `body` on its mesh; `output` takes rows and frames. However a run ends, the last state is
/// in history and frames, unless it is not finite.
///
/// Returns: outcome ("completed", "inverted", "unsolved", "diverged", "timed_out" or "interrupted"), steps
/// and steps_planned, kernel_s (stepping alone), time_step_s, engine ("plain", "tets" or "general", with
/// why_general), laws (of strain energies), precision, stable_step_s with stable_by and stability_margin
/// (bound / step; null without a bound), energies at the start and the end, counts (zero_length_springs,
/// speeds_cut, inverted_tets, ...) and state_hash. Of the plain engine in single precision it has
/// rounding_gain_j (core/dynamics/time_loop/plain_run.h) and rounding_gain_over_kinetic, over the greatest
/// kinetic energy of the history; else both are null.
nlohmann::json run_motion_setup(const MovingBody& body, const TetMesh& mesh, const MotionSetup& setup,
                                const MotionStops& stops, MotionOutput& output);

}  // namespace palpate::reference

// What became of a motion: watched step by step, and called by one of eight names.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "core/dynamics/time_loop/body_stepper.h"

namespace palpate::dynamics {

/// How a watched motion ended. With the kinetic energy's greatest value over the last quarter of the steps,
/// k, and the total energy counted from the least of the run:
///
///   kSteady         k <= 1e-6 of its greatest value, or below what rounding moves
///   kOscillating    moves on, and none of the below
///   kEnergyGrowing  the greatest energy over the last quarter is over 1.1 times that of each earlier quarter
///                   and over the start's by 0.1% of what there was or moves, and k has grown 1.1 times too.
///                   Or, if `energy_factor` is given, the energy has ever been over that many times the
///                   start's, or of its motion and strain if that is more
///   kGrowingSlowly  as kSteady or kOscillating, but the step is known to be too long (`is_known_to_grow`):
///   the run was
///                   too short to show it
///   kDiverged       stopped where a vertex was displaced beyond `escape_ratio` sizes of the body
///   kInverted       ended with tets that are not positive, without its energy growing
///   kNonFinite      stopped where a displacement or velocity was not finite (or a speed above 1e140 m/s)
///   kTooSlow        `give_up` asked to stop
enum class WatchedOutcome {
  kSteady,
  kOscillating,
  kEnergyGrowing,
  kDiverged,
  kInverted,
  kNonFinite,
  kTooSlow,
  kGrowingSlowly
};

/// "steady", "oscillating", "energy_growing", "diverged", "inverted", "non_finite", "too_slow" or
/// "growing_slowly".
const char* watched_outcome_name(WatchedOutcome outcome);

/// Whether the outcome says that the step was too long.
bool is_unstable(WatchedOutcome outcome);

/// How long a run is watched, and what ends it.
struct WatchOptions {
  double step_s = 0.0;
  std::uint64_t steps = 0;
  double escape_ratio = 1000.0;
  double energy_factor = 0.0;     ///< 0: energy may come in, by loads that change
  bool is_known_to_grow = false;  ///< small motions grow with this step, however slowly
  std::uint64_t samples = 400;  ///< at which energies and inverted tets are looked at, evenly over the steps
  std::function<bool()> give_up;  ///< asked at every sample; may be empty
  bool keeps_rows = false;        ///< fills WatchedRun::rows
};

/// The body at one sample, and the greatest and least energies of the samples since the row before. What is
/// no finite number is NaN.
struct WatchedRow {
  std::uint64_t step = 0;
  MotionEnergy energy;
  double most_kinetic_j = 0.0;
  double most_total_j = 0.0;
  double least_total_j = 0.0;
  double farthest_m = 0.0;  ///< largest displacement
  std::size_t inverted = 0;
  bool is_finite = true;  ///< displacements and velocities
  std::uint64_t unsolved = 0;
};

/// What was seen. Energies are finite: where one was not, the run had ended before.
struct WatchedRun {
  WatchedOutcome outcome = WatchedOutcome::kSteady;
  std::uint64_t steps = 0;      ///< taken, the one that ended it too
  double time_s = 0.0;          ///< of the outcome: its step, or the first sample that showed it
  Index vertex = kNoIndex;      ///< that offends first: not finite, escaped, of the first inverted tet, or
                                ///< the one with the most kinetic energy where energy grows; else none
  double energy_start_j = 0.0;  ///< kinetic, elastic and of loads
  double energy_least_j = 0.0;
  double energy_most_j = 0.0;
  double kinetic_most_j = 0.0;
  double kinetic_end_j = 0.0;        ///< greatest over the last quarter
  double drift_m = 0.0;              ///< largest displacement at the end; 0 if that is not finite
  std::uint64_t steps_unsolved = 0;  ///< whose solver did not come to its tolerance
  std::size_t inverted_start = 0;    ///< tets that are not positive
  std::size_t inverted_end = 0;
  std::vector<WatchedRow> rows;  ///< the start, the last sample of each fortieth of the steps, the end
};

/// Takes up to `options.steps` steps from `start`. Throws: InputError for a step that is not a finite number
/// above zero, no steps, fewer than 8 samples, an escape ratio that is not above zero, or an energy factor
/// that is not a number of at least 0.
WatchedRun watch_motion(BodyStepper& stepper, const MotionState& start, const WatchOptions& options);

}  // namespace palpate::dynamics

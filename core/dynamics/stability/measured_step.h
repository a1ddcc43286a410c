// The longest stable step as it is measured: by trying steps and halving the bracket.
#pragma once

#include <cstdint>
#include <vector>

#include "core/dynamics/time_loop/body_stepper.h"

namespace palpate::dynamics {

/// The model with linear springs and strain laws: its forces are linear in displacement and velocity, so that
/// a motion of any size shows what small ones do. Throws: InputError for the thesis's volume force, which has
/// no linear form.
MotionModel linearise(MotionModel model);

/// How measure_stable_step tries steps, and when it calls one too long.
struct MeasureStepOptions {
  double first_step_s = 0.0;           ///< where the search starts; any will do
  double amplitude_m = 1e-6;           ///< of the random displacements, and of the velocities times the step
  std::uint64_t seed = 1;              ///< of both
  std::uint64_t horizon_least = 1024;  ///< steps of a trial that shows no growth
  std::uint64_t horizon_most = 16384;  ///< steps of one that grows slowly
  bool counts_slow_growth = true;      ///< false: growth is what exceeds the start's energy by growth_factor
  double growth_factor = 1e6;          ///< energies over the start's that are growth for certain
  double tolerance = 0.005;            ///< the bracket's upper end over its lower, minus 1
  double stride = 2.0;    ///< the first step is multiplied or divided by it until it is bracketed
  int most_strides = 24;  ///< at most so often
};

/// A stretch of a trial: its last step, and the mean and the greatest kinetic energy over its steps (infinity
/// where it is no number).
struct TrialStretch {
  std::uint64_t until = 0;
  double mean_kinetic_j = 0.0;
  double most_kinetic_j = 0.0;
};

/// What was seen of one tried step.
struct MeasuredTrial {
  std::uint64_t steps = 0;
  double start_j = 0.0;  ///< kinetic and elastic energy of the start; of trials about rest alone
  std::vector<TrialStretch> stretches;  ///< of trials about rest alone
  double growth = 0.0;                  ///< |z|^2 - 1, of measure_stable_step_by_map alone
};

/// The bracket that is left. No stable step found: stable_s is 0. No unstable one: unstable_s is infinity.
struct MeasuredStep {
  double stable_s = 0.0;    ///< the longest step that was seen to be stable
  double unstable_s = 0.0;  ///< the shortest that was not
  std::uint64_t trials = 0;
  std::uint64_t steps = 0;  ///< over all trials
  MeasuredTrial stable;     ///< that of stable_s
  MeasuredTrial unstable;   ///< that of unstable_s

  bool is_found() const;
  /// sqrt(stable_s x unstable_s). Requires: is_found().
  double step_s() const;
};

/// Measures how long a step keeps small motions about rest bounded.
///
/// A trial starts with seeded random displacements and velocities and takes 512 steps, then twice as many and
/// so on. With M the mean kinetic energy over a stretch of steps, it has grown if M of the run's second half
/// is over 1000 times that of the quarter before, if a single step had over `growth_factor` times the energy
/// of the start, or if it is no number. It is stable once `horizon_least` steps are over and that ratio is
/// below 1.02; while it is not, the trial goes on, and at `horizon_most` steps it has grown if the ratio is
/// above 1.02 and no less than the one before: growth has a ratio that is squared from stretch to stretch,
/// and that of a bounded oscillation, however large near the bound, goes to 1. (The greatest energy of a
/// stretch does not: longer stretches meet rarer peaks.) Kinetic energy leaves drifting and turning bodies
/// alone.
///
/// Where forces are not linear, growth comes to an end when the motion is large (a body of strong axial
/// damping then bends to a shape in which the step is stable, and comes to rest); and in single precision,
/// rounding adds energy at a steady rate. So `counts_slow_growth` is for linear models in double precision.
///
/// Growth by g a step is seen if g x horizon_least exceeds about 0.04, or if it is slower but nothing else
/// moves as much. Explicit Euler, whose growth just over its bound may be tiny, needs horizon_least as long
/// as horizon_most.
///
/// Throws: InputError for a first step, amplitude, growth factor or tolerance that is not finite and above
/// zero, a stride that is not above 1, or a horizon below 512 steps.
MeasuredStep measure_stable_step(BodyStepper& stepper, const MeasureStepOptions& options);

/// How measure_stable_step_from tries steps.
struct MeasureLargeOptions {
  double first_step_s = 0.0;
  std::uint64_t steps = 2000;  ///< of a trial
  double energy_factor = 10.0;
  double tolerance = 0.02;
  int most_doublings = 24;  ///< of the first step, either way
};

/// The same with the full forces, from a deformed state: a step is too long if watch_motion, with the energy
/// factor, calls the motion unstable. Large motions need not tell two steps apart as sharply as a growing
/// mode does: trials of another number of steps may end a few percent elsewhere. Throws: InputError as
/// measure_stable_step and watch_motion do.
MeasuredStep measure_stable_step_from(BodyStepper& stepper, const MotionState& start,
                                      const MeasureLargeOptions& options);

}  // namespace palpate::dynamics

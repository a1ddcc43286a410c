// The time loop of the plain engine and the tet engine: the same report as run_motion.
#pragma once

#include "core/dynamics/spring_engine/plain_engine.h"
#include "core/dynamics/time_loop/motion_run.h"

namespace palpate::dynamics {

/// A run with the plain engine or the tet engine.
struct PlainRunOptions {
  MotionRunOptions run;
  int threads = 1;
  double speed_limit_m_s = 0.0;
  bool single_precision = false;
};

/// The energy in J that rounding of positions in single precision adds to an undamped body a step, in the
/// mean: each coordinate x is off by up to half its last bit, evenly, and independently from step to step, so
/// that
///
///   gain = sum over free coordinates of 1/2 K_ii ulp(x_i)^2 / 12,
///
/// K at rest, x from the rest shape's centre. Forces that are found from rounded positions add to it where
/// h omega is near 1 (docs/engine_speed.md). Damping takes it away again; where h v is below a last bit, the
/// body stands still instead.
double rounding_gain_per_step(const MotionModel& model);

/// As run_motion with symplectic Euler, on the plain engine. A displacement counts as an escape where a
/// vertex is farther than escape_ratio times the longest side from the rest shape's centre. Of zero-length
/// springs, the steps are counted that have some.
/// Throws: as PlainEngine; InputError for a step that is not a finite number above zero.
MotionReport run_plain_motion(const MotionModel& model, MotionState& state, const PlainRunOptions& options,
                              const MotionObserver& observer = {});

/// The same on the tet engine. Throws: as TetEngine; InputError for a step that is not a finite number above
/// zero.
MotionReport run_tet_motion(const MotionModel& model, MotionState& state, const PlainRunOptions& options,
                            const MotionObserver& observer = {});

}  // namespace palpate::dynamics

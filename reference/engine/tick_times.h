// A haptic loop without a device: ticks of simulated time of whatever steps a body, each timed.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/dynamics/integrators/integrator.h"
#include "core/dynamics/motion/motion_model.h"
#include "reference/door/moving_body.h"
#include "reference/elastic_models/tick_report.h"

namespace palpate::reference {

struct TickOptions {
  TickLoop loop;
  std::uint64_t steps_per_tick = 1;
  EngineChoice engine = EngineChoice::kPlain;  ///< what steps; never kAuto
  bool single_precision = true;                ///< kPlain and kTets alone
  dynamics::IntegratorOptions integrator;      ///< threads and speed limit of all; the rest of kGeneral
  std::size_t tool = 0;                        ///< the group of loads whose force is read each tick
};

/// What came of it.
///
/// Shape:  one time a timed tick; one force a tick, those before included. The plain and the tet engine give
///         the force at the start of the tick's last step, which they have added up on the way; the general
///         engine that at the tick's end, for which it evaluates all forces once more.
struct TickRun {
  std::vector<double> seconds;
  std::vector<Vec3> force_n;
  dynamics::MotionState state;
  bool diverged = false;      ///< a state was not finite, or beyond 1000 sizes: there are fewer ticks
  double diverged_s = 0.0;    ///< time of the tick in which that was
  double prepare_s = 0.0;     ///< to make what steps, before the first tick
  double first_tick_s = 0.0;  ///< the first of all, which the implicit ones factor in; 0 where none ended
  std::uint64_t solver_iterations = 0;
  std::uint64_t steps_unsolved = 0;      ///< whose solver did not come to its tolerance
  std::optional<double> residual_worst;  ///< as StepReport::residual_relative, where it was measured
};

/// Steps from rest. A tick takes `steps_per_tick` steps of tick_s / steps_per_tick and reads the tool's
/// force; its time is a TickClock's, without input or output within it, and without allocation on the plain
/// and the tet engine. Throws: as PlainEngine, TetEngine or Integrator.
TickRun run_ticks(const dynamics::MotionModel& model, const TickOptions& options);

}  // namespace palpate::reference

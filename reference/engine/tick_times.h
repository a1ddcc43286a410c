// A haptic loop without a device: ticks of simulated time on the plain engine, each timed.
#pragma once

#include <cstdint>
#include <vector>

#include "core/dynamics/motion/motion_model.h"
#include "reference/elastic_models/tick_report.h"

namespace palpate::reference {

struct TickOptions {
  TickLoop loop;
  std::uint64_t steps_per_tick = 1;
  int threads = 1;
  bool single_precision = true;
  std::size_t tool = 0;  ///< the group of loads whose force is read each tick
};

/// What came of it.
///
/// Shape:  one time a timed tick; one force a tick, those before included, at the start of its last step.
struct TickRun {
  std::vector<double> seconds;
  std::vector<Vec3> force_n;
  dynamics::MotionState state;
  bool diverged = false;    ///< a state was not finite: there are fewer ticks
  double diverged_s = 0.0;  ///< time of the tick in which that was
};

/// Steps from rest. A tick takes `steps_per_tick` steps of tick_s / steps_per_tick and reads the tool's
/// force; its time is a TickClock's, without allocation, input or output within it. Throws: as PlainEngine.
TickRun run_ticks(const dynamics::MotionModel& model, const TickOptions& options);

}  // namespace palpate::reference

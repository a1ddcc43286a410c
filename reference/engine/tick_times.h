// A haptic loop without a device: ticks of simulated time on the plain engine, each timed.
#pragma once

#include <cstdint>
#include <vector>

#include "core/dynamics/motion/motion_model.h"

namespace palpate::reference {

struct TickOptions {
  double tick_s = 1e-3;
  std::uint64_t steps_per_tick = 1;
  std::uint64_t ticks = 2000;
  std::uint64_t warm_ticks = 200;  ///< before those that are timed
  int threads = 1;
  bool single_precision = true;
  bool paced = false;    ///< each tick waits until it is due, as a device asks for it
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
/// force; its time is that between two readings of the steady clock, without allocation, input or output
/// between them. Ticks follow each other at once; or, paced, each starts tick_s after the one before, and how
/// late the system wakes it counts as its time. A tick that is due while the one before still runs starts
/// after it. Throws: as PlainEngine.
TickRun run_ticks(const dynamics::MotionModel& model, const TickOptions& options);

/// Distribution of times, in s.
struct TickTimes {
  double p50_s = 0.0;
  double p99_s = 0.0;
  double p99_9_s = 0.0;
  double worst_s = 0.0;
  double mean_s = 0.0;
  std::uint64_t missed = 0;           ///< longer than the deadline
  std::vector<double> bucket_ends_s;  ///< twenty a decade, from the least time to the worst
  std::vector<std::uint64_t> buckets;
};

/// A percentile is the time that so many percent of the ticks do not exceed: one of the times, none made up
/// between two. Requires: at least one time, all above zero.
TickTimes describe_ticks(std::vector<double> seconds, double deadline_s);

}  // namespace palpate::reference

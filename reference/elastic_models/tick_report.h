// Ticks of a haptic loop, whoever answers them: what is asked, how times are described, the forces as a file.
#pragma once

#include <chrono>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <vector>

#include "core/base/types.h"
#include "reference/door/motion_problem.h"

namespace palpate::reference {

/// How a loop ticks.
struct TickLoop {
  double tick_s = 1e-3;
  std::uint64_t ticks = 2000;
  std::uint64_t warm_ticks = 200;  ///< before those that are timed
  bool paced = false;              ///< each tick waits until it is due, as a device asks for it
};

/// Takes tick_s, ticks (a tenth of as many warm ones come before) and paced. Throws: InputError.
TickLoop take_tick_loop(nlohmann::json& options);

/// Takes `vertices`, which the runner has read: the mesh is there already. Throws: InputError.
void take_mesh_vertices(nlohmann::json& options);

/// The steady clock of a loop: a tick's time is that between two readings of it. Ticks follow each other at
/// once; or, paced, each starts tick_s after the one before, and how late the system wakes it counts as its
/// time. A tick that is due while the one before still runs starts after it.
class TickClock {
 public:
  explicit TickClock(const TickLoop& loop);

  /// Starts the first tick.
  void start();
  /// Ends a tick and starts the next, which may wait until it is due. No memory is asked for.
  void end_tick();

  std::uint64_t ticks() const { return done_; }
  /// Since the tick that runs was started.
  double seconds_of_running() const;
  /// Of one that has ended, the warm ones counted from 0.
  double seconds_of(std::uint64_t tick) const;
  /// Of the ticks after the warm ones, one each.
  std::vector<double> seconds() const;

 private:
  using Clock = std::chrono::steady_clock;
  TickLoop loop_;
  Clock::duration period_;
  std::uint64_t done_ = 0;
  std::vector<Clock::time_point> begin_;
  std::vector<Clock::time_point> end_;
};

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

/// Adds ticks and their times to a report.
void add_tick_times(const std::vector<double>& seconds, double tick_s, nlohmann::json& report);

/// palpate/engine/1 of the kind "ticks": some of the forces with their times, one force a tick, and those of
/// the last tenth all; none of those where the run ended early.
nlohmann::json describe_tick_forces(std::span<const Vec3> force_n, double tick_s, bool ended_early);

/// The place of the only tool among the loads of a motion. Throws: InputError for a load that comes or goes,
/// or another number of tools.
std::size_t find_only_tool(const MotionProblem& problem);

}  // namespace palpate::reference

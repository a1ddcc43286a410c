// What engines that step by blocks share: threads that step together, each with blocks of its own, and what
// they look at on the way.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "core/base/lanes.h"
#include "core/base/threads.h"
#include "core/dynamics/spring_engine/plain_loads.h"
#include "core/dynamics/spring_engine/plain_options.h"

namespace palpate::dynamics {

/// What a vertex has of its own.
template <typename Real>
struct Inertia {
  Real inverse_mass = 0;  ///< 0 where it is held
  Real drag = 0;
};

/// The fastest and the farthest vertex of a block after a step; the sum keeps what is not finite.
template <typename Real>
struct Watched {
  Real speed_sq = 0;
  Real farthest_sq = 0;
  Real sum = 0;

  /// Another vertex, so far from the rest shape's centre and so fast (squares).
  void note(Real away_sq, Real vertex_speed_sq) {
    farthest_sq = std::max(farthest_sq, away_sq);
    speed_sq = std::max(speed_sq, vertex_speed_sq);
    sum += away_sq + vertex_speed_sq;
  }
};

/// Whether all blocks are finite and none has a vertex beyond `escape_m`; if so the peak speed is noted.
template <typename Real>
bool is_within(std::span<const Watched<Real>> blocks, double escape_m, PlainReport& report) {
  const auto escape = static_cast<Real>(escape_m);
  bool good = true;
  Real speed_sq = 0;
  for (const Watched<Real>& seen : blocks) {
    good = good && std::isfinite(seen.sum) && seen.farthest_sq <= escape * escape;
    speed_sq = std::max(speed_sq, seen.speed_sq);
  }
  if (good) report.peak_speed_m_s = std::max(report.peak_speed_m_s, std::sqrt(static_cast<double>(speed_sq)));
  return good;
}

/// A velocity cut to the limit, and counted, where it is longer.
template <typename Real>
Lanes<Real> cut_speed(const Lanes<Real>& speed, double limit_m_s, PlainReport& report) {
  std::array<Real, 4> each;
  speed.store(each.data());
  const auto limit = static_cast<Real>(limit_m_s);
  const Real speed_sq = each[0] * each[0] + each[1] * each[1] + each[2] * each[2];
  if (!(speed_sq > limit * limit)) return speed;
  ++report.speeds_cut;
  return Lanes<Real>::of(limit / std::sqrt(speed_sq)) * speed;
}

/// Work on one block by one thread. `own` is the thread's: it counts the speeds that it cuts, and marks a
/// step with a spring of no length by steps_with_zero_length above 0.
using BlockWork = std::function<void(std::size_t block, std::size_t thread, PlainReport& own)>;

/// What a team of threads does in a step: all phases in turn, each on all blocks before the next one begins,
/// then `swap`, by one thread.
template <typename Real>
struct TeamStep {
  std::vector<BlockWork> phases;
  std::function<void()> swap;                ///< what the step made becomes what there is; must not throw
  std::span<const Watched<Real>> watched{};  ///< of each block, if options.escape_m is above 0
  std::size_t blocks = 0;
};

/// The number of threads that have blocks to work on; at least 1.
inline std::size_t team_size(const PlainOptions& options, std::size_t blocks) {
  if (!kHasThreads) return 1;
  return std::clamp<std::size_t>(static_cast<std::size_t>(std::max(options.threads, 1)), 1,
                                 std::max<std::size_t>(blocks, 1));
}

/// Takes `steps` steps of length `step_s` from `time_s`, which moves along, or fewer if one leaves a state
/// that is not within bounds.
template <typename Real>
PlainReport step_in_team(const PlainOptions& options, const TeamStep<Real>& step, double step_s,
                         std::uint64_t steps, PlainLoads& loads, double& time_s,
                         const PlainObserver& observer) {
  const std::size_t threads = team_size(options, step.blocks);
  std::vector<PlainReport> own(threads);
  std::uint64_t cuts_before = 0;
  PlainReport sum;
  bool is_over = false;
  if (steps == 0) return sum;
  loads.set_times(time_s, time_s + step_s);
  const auto end_step = [&]() noexcept {
    step.swap();
    ++sum.steps;
    time_s += step_s;
    loads.gather();
    loads.set_times(time_s, time_s + step_s);
    sum.diverged = options.escape_m > 0.0 && !is_within(step.watched, options.escape_m, sum);
    is_over = sum.diverged || sum.steps == steps;
    bool has_zero = false;
    sum.speeds_cut = 0;
    for (PlainReport& each : own) {
      has_zero = has_zero || each.steps_with_zero_length > 0;
      each.steps_with_zero_length = 0;
      sum.speeds_cut += each.speeds_cut;
    }
    sum.steps_with_zero_length += has_zero ? 1 : 0;
    sum.steps_with_cuts += sum.speeds_cut > cuts_before ? 1 : 0;
    cuts_before = sum.speeds_cut;
    if (observer) observer(sum.steps);
  };
  const auto go_on = []() noexcept {};
  Meeting<decltype(go_on)> between(static_cast<std::ptrdiff_t>(threads), go_on);
  Meeting<decltype(end_step)> end(static_cast<std::ptrdiff_t>(threads), end_step);
  const auto work = [&](std::size_t t) {
    PlainReport mine;  // not beside another thread's in memory
    for (;;) {
      for (std::size_t p = 0; p < step.phases.size(); ++p) {
        if (p > 0) between.arrive_and_wait();
        for (std::size_t b = step.blocks * t / threads; b < step.blocks * (t + 1) / threads; ++b)
          step.phases[p](b, t, mine);
      }
      own[t] = mine;
      mine.steps_with_zero_length = 0;
      end.arrive_and_wait();
      if (is_over) return;
    }
  };
  {
    StartGate gate;  // if not all threads can be made, those that were would wait at the barriers for ever
    std::vector<Thread> others;
    try {
      for (std::size_t t = 1; t < threads; ++t) {
        others.emplace_back([&gate, &work, t] {
          if (gate.may_start()) work(t);
        });
      }
    } catch (...) {
      gate.open(false);
      throw;
    }
    gate.open(true);
    work(0);
  }
  return sum;
}

}  // namespace palpate::dynamics

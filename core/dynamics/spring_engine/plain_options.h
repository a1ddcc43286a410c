// How an engine that steps by blocks runs, and what it reports.
#pragma once

#include <cstdint>
#include <functional>

namespace palpate::dynamics {

/// How the plain engine and the tet engine run, and what they watch.
struct PlainOptions {
  int threads = 1;
  double speed_limit_m_s = 0.0;  ///< 0: no limit; held vertices are not cut
  /// Above 0: each step is watched. Peak speeds are reported, and the first state that is not finite or has a
  /// vertex farther than this from the rest shape's centre is the last.
  double escape_m = 0.0;
  bool portable = false;  ///< do without AVX2 where there is one; the bits are the same
};

/// What happened in some steps.
struct PlainReport {
  std::uint64_t steps = 0;       ///< taken
  std::uint64_t speeds_cut = 0;  ///< vertices times steps
  std::uint64_t steps_with_cuts = 0;
  std::uint64_t steps_with_zero_length = 0;  ///< in which a spring had no length (below 1e-18 m) and no force
  double peak_speed_m_s = 0.0;               ///< of the watched steps, held vertices included
  bool diverged = false;                     ///< watched, and stopped at the last state
};

/// Called after each step, with its number from 1, by one thread while the others wait: it may read state()
/// and group_forces(), must not throw and should be short.
using PlainObserver = std::function<void(std::uint64_t step)>;

}  // namespace palpate::dynamics

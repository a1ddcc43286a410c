// A finger that presses, slides, lifts and lets go of a body, cycle after cycle at places of the skin at
// random.
#pragma once

#include <cstdint>
#include <string>

#include "core/base/random.h"
#include "live/body/live_body.h"

namespace palpate::soak {

/// How the finger moves. Every time is a whole number of ticks of 1 ms.
struct FingerOptions {
  std::uint64_t seed = 1;
  double radius_m = 0.01;
  double stiffness_pa_per_m = 5e6;
  double deepest_m = 0.005;     ///< a cycle goes to between 0.3 and 1 of it
  double share_of_bound = 0.9;  ///< of the predicted stable step
};

/// Ticks of 1 ms of a cycle: down, held, up, and without a finger. In every other cycle, at random, the
/// finger slides while it is held: it rises to a third of its depth, slides there, and goes down again.
inline constexpr std::uint64_t kDownTicks = 200;
inline constexpr std::uint64_t kHeldTicks = 300;  ///< 100 of them before the slide, 100 behind it
inline constexpr std::uint64_t kUpTicks = 200;
inline constexpr std::uint64_t kFreeTicks = 1300;
inline constexpr std::uint64_t kCycleTicks = kDownTicks + kHeldTicks + kUpTicks + kFreeTicks;

/// What a cycle was like: at the end of its hold, and at its own end, when the body has been let alone.
struct CycleFigures {
  Index vertex = kNoIndex;  ///< where it was pressed
  double depth_m = 0.0;
  bool has_slid = false;
  live::LiveReport pressed;
  live::LiveReport rest;
  Vec3 mean_offset_m;  ///< at its end: the mean displacement of all vertices; zero at rest
  std::string hash;    ///< of displacements and velocities at its end, all bits of them
};

/// Takes a body through cycles.
class Palpation {
 public:
  /// Holds a reference to the body. The step is the longest below a share of the predicted bound, with the
  /// finger anywhere, of which a tick has a whole number.
  /// Throws: InputError if there is no such step of a ten-thousandth of a tick or more.
  Palpation(live::LiveBody& body, const FingerOptions& options);

  std::uint64_t steps_per_tick() const { return steps_per_tick_; }
  double step_s() const { return step_s_; }

  /// One cycle. It ends early with a body that is broken: then `rest.is_broken` is set.
  CycleFigures run_cycle();

 private:
  bool step_ticks(std::uint64_t ticks);
  Index neighbour_of(Index vertex);
  bool hold(const Vec3& inward, Index slide_to);
  void measure_end(CycleFigures& out);

  live::LiveBody& body_;
  FingerOptions options_;
  SplitMix64 random_;
  std::uint64_t steps_per_tick_ = 0;
  double step_s_ = 0.0;
};

}  // namespace palpate::soak

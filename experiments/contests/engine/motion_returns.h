// How a body comes back to rest after each tool has let go.
#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <vector>

#include "reference/door/motion_problem.h"

namespace palpate::experiments {

/// How far a body is from its rest shape at one time.
struct MotionLevel {
  double time_s = 0.0;
  double largest_m = 0.0;
  double rms_m = 0.0;
};

/// From the moment that a tool lets go to the moment that the next load comes, or the end.
struct MotionReturn {
  std::size_t load = 0;  ///< the tool's place in the problem's list of loads
  double released_s = 0.0;
  double end_s = 0.0;
  double released_m = 0.0;  ///< largest displacement of all vertices when it lets go
  double left_m = 0.0;      ///< at the end
  double left_rms_ratio = 0.0;
  double half_s = -1.0;       ///< after letting go, until it stays below a half; -1: not before the end
  double twentieth_s = -1.0;  ///< ... below a twentieth

  double error() const { return released_m > 0.0 ? left_m / released_m : 0.0; }
};

/// One for each tool of the problem that lets go (`until_s`) before the end, in the order of time. `levels`
/// are in the order of time too; the run may have ended early: a tool that was never let go is left out.
std::vector<MotionReturn> find_returns(const reference::MotionProblem& problem,
                                       std::span<const MotionLevel> levels);

/// As a list of objects; a time that was not reached is null.
nlohmann::json returns_to_json(std::span<const MotionReturn> returns);

}  // namespace palpate::experiments

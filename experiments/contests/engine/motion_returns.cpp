#include "experiments/contests/engine/motion_returns.h"

#include <algorithm>

namespace palpate::experiments {
namespace {

using nlohmann::json;

/// The last level at or before a time, to a rounding of it; the first one if there is none.
std::size_t level_at(std::span<const MotionLevel> levels, double time_s) {
  std::size_t found = 0;
  for (std::size_t k = 0; k < levels.size(); ++k) {
    if (levels[k].time_s <= time_s * (1.0 + 1e-9)) found = k;
  }
  return found;
}

/// When the load after a time comes; the end if none does.
double next_load(const reference::MotionProblem& problem, double time_s) {
  double next = problem.duration_s;
  for (const reference::MotionLoad& load : problem.loads) {
    if (load.from_s >= time_s) next = std::min(next, load.from_s);
  }
  return next;
}

/// After `first`, the time until the level stays at or below `bound` up to `last`; -1 if it ends above.
double time_below(std::span<const MotionLevel> levels, std::size_t first, std::size_t last, double bound) {
  if (levels[last].largest_m > bound) return -1.0;
  std::size_t k = last;
  while (k > first && levels[k - 1].largest_m <= bound) --k;
  return levels[k].time_s - levels[first].time_s;
}

}  // namespace

std::vector<MotionReturn> find_returns(const reference::MotionProblem& problem,
                                       std::span<const MotionLevel> levels) {
  std::vector<MotionReturn> out;
  for (std::size_t k = 0; k < problem.loads.size(); ++k) {
    const reference::MotionLoad& load = problem.loads[k];
    if (!load.is_tool() || !load.until_s) continue;
    if (*load.until_s >= problem.duration_s || levels.empty() || levels.back().time_s < *load.until_s)
      continue;
    MotionReturn each;
    each.load = k;
    each.released_s = *load.until_s;
    each.end_s = next_load(problem, each.released_s);
    const std::size_t first = level_at(levels, each.released_s);
    const std::size_t last = std::max(first, level_at(levels, each.end_s));
    each.released_m = levels[first].largest_m;
    each.left_m = levels[last].largest_m;
    each.left_rms_ratio = levels[first].rms_m > 0.0 ? levels[last].rms_m / levels[first].rms_m : 0.0;
    each.half_s = time_below(levels, first, last, 0.5 * each.released_m);
    each.twentieth_s = time_below(levels, first, last, 0.05 * each.released_m);
    out.push_back(each);
  }
  std::stable_sort(out.begin(), out.end(),
                   [](const MotionReturn& a, const MotionReturn& b) { return a.released_s < b.released_s; });
  return out;
}

json returns_to_json(std::span<const MotionReturn> returns) {
  json list = json::array();
  const auto time = [](double value) { return value >= 0.0 ? json(value) : json(nullptr); };
  for (const MotionReturn& each : returns) {
    list.push_back({{"load", each.load + 1},
                    {"released_s", each.released_s},
                    {"end_s", each.end_s},
                    {"released_m", each.released_m},
                    {"left_m", each.left_m},
                    {"error", each.error()},
                    {"rms_error", each.left_rms_ratio},
                    {"half_s", time(each.half_s)},
                    {"twentieth_s", time(each.twentieth_s)}});
  }
  return list;
}

}  // namespace palpate::experiments

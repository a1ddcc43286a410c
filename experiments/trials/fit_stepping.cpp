#include "experiments/trials/fit_stepping.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "experiments/records/record_file.h"
#include "experiments/scene_reader/scene_require.h"
#include "experiments/text/figure_text.h"
#include "experiments/text/terminal.h"

namespace palpate::experiments {
namespace {

constexpr double kStepRounding = 1e-9;  // a halved step may miss the shortest one by that share

std::string error_text(const SteppingTry& tried) {
  return tried.error ? "leaves " + percent_text(*tried.error) + " of the motion" : "does not end";
}

}  // namespace

void FitStepping::apply(const nlohmann::json& step, nlohmann::json& scene) const {
  nlohmann::json& dynamic = scene["analysis"]["dynamic"];
  for (const char* key : {"safety", "engine", "solver", "precision"}) dynamic.erase(key);
  dynamic["integrator"] = integrator;
  dynamic["time_step_s"] = step;
  if (single_precision) dynamic["precision"] = "single";
  if (!solver.is_null()) dynamic["solver"] = solver;
  if (modes) scene["model"]["modes"] = *modes;
}

std::string FitStepping::cannot(const std::vector<std::string>& needs) const {
  const std::vector<std::string>& things = changeable_things();
  for (const std::string& need : needs) {
    if (std::find(things.begin(), things.end(), need) == things.end()) continue;
    if (std::find(may_change.begin(), may_change.end(), need) == may_change.end()) return need;
  }
  return "";
}

std::string over_memory(std::uint64_t bytes, const std::optional<std::uint64_t>& most) {
  if (!most || bytes <= *most) return "";
  return "takes " + std::to_string(bytes) + " bytes, over " + std::to_string(*most);
}

double SteppingTry::cost() const {
  return cost_s.empty() ? std::numeric_limits<double>::infinity() : median(cost_s);
}

SteppingTry find_step(const FitStepping& stepping, double longest_s, double shortest_s, double most_error,
                      double most_cost_s, const std::function<SteppedMotion(double step_s)>& run) {
  SteppingTry tried;
  tried.stepping = stepping;
  tried.why_not = "its longest step, " + time_text(longest_s) +
                  ", is shorter than the shortest that is tried, " + time_text(shortest_s);
  double step_s = longest_s;
  while (step_s >= shortest_s * (1.0 - kStepRounding)) {
    const SteppedMotion found = run(step_s);
    tried.step_s = step_s;
    tried.error = found.error;
    tried.cost_s = {found.cost_s};
    tried.memory_bytes = std::max(tried.memory_bytes, found.memory_bytes);
    tried.why_not.clear();
    if (found.ending.empty() && found.error && *found.error <= most_error) return tried;
    tried.why_not =
        (found.ending.empty() ? error_text(tried) : found.ending) + " at a step of " + time_text(step_s);
    if (!std::isfinite(found.cost_s)) return tried;
    if (found.cost_s > most_cost_s) {
      tried.why_not += ", and takes " + time_text(found.cost_s) + " already, over " + time_text(most_cost_s);
      return tried;
    }
    step_s *= 0.5;
  }
  return tried;
}

const SteppingTry* choose_stepping(const std::vector<SteppingTry>& tries) {
  const SteppingTry* best = nullptr;
  for (const SteppingTry& tried : tries) {
    if (!tried.why_not.empty()) continue;
    if (best == nullptr || tried.cost() < best->cost()) best = &tried;
  }
  return best;
}

}  // namespace palpate::experiments

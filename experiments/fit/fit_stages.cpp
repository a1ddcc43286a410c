#include "experiments/fit/fit_stages.h"

#include <algorithm>
#include <filesystem>
#include <numeric>
#include <optional>
#include <utility>

#include "experiments/processes/deadline.h"
#include "experiments/processes/machine_load.h"
#include "experiments/records/record_file.h"
#include "experiments/runner/read_plan.h"
#include "experiments/runner/runner.h"
#include "experiments/runner/side_by_side.h"

namespace palpate::experiments {
namespace fs = std::filesystem;
namespace {

using nlohmann::json;

constexpr int kMostReferences = 2;  ///< at a time: each takes up to 3 GB
constexpr int kTimingRepeats = 5;
constexpr double kFurtherShare = 0.3;  ///< of what is left: then no further loads are looked at any more
constexpr double kTimingShare = 0.15;  ///< of what is left: then nothing is timed again any more

std::string names_of(const std::vector<FitCandidate>& candidates) {
  std::string text;
  for (const FitCandidate& each : candidates) text += (text.empty() ? "" : "; ") + each.name();
  return text;
}

}  // namespace

void FitStages::begin(FitPlan search, std::vector<json> others) {
  search_ = std::move(search);
  others_ = std::move(others);
}

double FitStages::left_s(double share) const {
  return share * options_.time_limit_s - watch_.seconds();
}

void FitStages::prepare_references(const std::vector<std::string>& scenes) {
  SideBySide setting;
  setting.jobs = std::min(usable_processors(), kMostReferences);
  if (setting.jobs < 2 || left_s() <= 0.0) return;
  progress_.show_long("references");
  FitPlan plan = search_;
  plan.folder = options_.out / "references";
  plan.candidates.resize(1);
  plan.scenes.insert(plan.scenes.end(), others_.begin(), others_.end());
  setting.plan = write_fit_plan(plan, candidates_);
  setting.folder = plan.folder / "runs";
  const Deadline deadline(left_s(), options_.stop_flag);
  setting.stop_flag = deadline.flag();
  prepare_side_by_side(scenes, setting);
}

void FitStages::run(const FitPlan& fit_plan, double seconds) {
  const fs::path file = write_fit_plan(fit_plan, candidates_);
  const Plan plan = read_plan(file, registry_);
  require_available(plan, registry_);
  const Deadline deadline(seconds, options_.stop_flag);
  RunOptions options;
  options.folder = fit_plan.folder / "run";
  options.stop_flag = deadline.flag();
  if (!run_plan(plan, registry_, options, progress_).interrupted) return;
  is_complete_ = false;
  is_interrupted_ = options_.stop_flag != nullptr && *options_.stop_flag != 0;
}

void FitStages::run_short(const FitPlan& plan, double seconds) {
  const bool was_complete = is_complete_;
  run(plan, seconds);
  if (!is_interrupted_) is_complete_ = was_complete;
}

std::vector<FitPoint> FitStages::read(const FitPlan& plan) const {
  const fs::path records = plan.folder / "run" / "records.jsonl";
  if (!fs::exists(records)) return read_fit_points({}, plan, require_);
  return read_fit_points(read_records(records), plan, require_);
}

FitPlan FitStages::plan_check(std::size_t other_loads) {
  FitPlan plan = search_;
  plan.folder = options_.out / ("check_" + std::to_string(checks_++));
  plan.measures_answers = false;
  plan.candidates.clear();
  const auto last = others_.begin() + static_cast<std::ptrdiff_t>(other_loads);
  plan.scenes.insert(plan.scenes.end(), others_.begin(), last);
  return plan;
}

std::vector<FitPoint> FitStages::run_check(const FitPlan& plan, double seconds) {
  progress_.show_long("checks " + names_of(plan.candidates));
  run(plan, seconds);
  std::vector<FitPoint> points = read(plan);
  time_again(plan, points);
  return points;
}

/// Runs those that meet the tolerance some times more on the scene itself: which is the cheapest is told by
/// medians. Without the time for it, what was measured before stands: a choice is to be confirmed yet.
void FitStages::time_again(const FitPlan& check, std::vector<FitPoint>& points) {
  FitPlan plan = check;
  plan.folder = check.folder / "timing";
  plan.repeats = kTimingRepeats;
  plan.scenes.resize(1);
  plan.candidates.clear();
  for (const FitPoint* point : choose_cheapest(points, require_)) plan.candidates.push_back(point->candidate);
  if (plan.candidates.empty() || left_s() <= 0.0) return;
  run_short(plan, kTimingShare * left_s());
  for (const FitPoint& timed : read(plan)) {
    const FitCandidate& own = timed.candidate;
    for (FitPoint& point : points) {
      const bool is_same = plan_label(point.candidate) == plan_label(own);
      if (is_same && timed.failure.empty() && !timed.cost_s.empty()) point.cost_s = timed.cost_s;
    }
  }
}

/// Numbers of the further loads on which a candidate is the farthest off, the worst first, against
/// quadratic elements on the scene's own mesh: that tells which, in a fraction of the time. Loads that
/// there was no time for come last, in their order. `looked_at` is told how many were looked at.
std::vector<std::size_t> FitStages::rank_further_loads(const FitCandidate& candidate,
                                                       std::size_t& looked_at) {
  FitPlan plan = search_;
  plan.folder = options_.out / ("look_" + std::to_string(looks_++));
  plan.levels = 1;
  plan.measures_answers = false;
  plan.work = FitWork::kFirst;  // nothing is timed
  plan.candidates = {candidate};
  plan.scenes.assign(others_.begin() + kOtherLoads, others_.end());
  progress_.show_long("looks for the loads on which " + candidate.name() + " is the farthest off");
  run_short(plan, kFurtherShare * left_s());
  const fs::path records = plan.folder / "run" / "records.jsonl";
  std::vector<std::optional<double>> errors(kFurtherLoads);
  if (fs::exists(records)) errors = read_errors(read_records(records), plan, require_, candidate);
  std::vector<std::size_t> order(kFurtherLoads);
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return errors[a].value_or(-1.0) > errors[b].value_or(-1.0);
  });
  looked_at = static_cast<std::size_t>(
      std::count_if(errors.begin(), errors.end(), [](const auto& error) { return error.has_value(); }));
  for (std::size_t& number : order) number += 1 + kOtherLoads;
  return order;
}

bool FitStages::confirm(FitPoint& point) {
  if (point.error.size() > 1 + kOtherLoads || left_s() <= 0.0) return true;
  std::size_t looked_at = 0;
  std::vector<std::size_t> loads = rank_further_loads(point.candidate, looked_at);
  loads.resize(kConfirmingLoads);
  FitPlan plan = plan_check(0);
  std::vector<std::string> names;
  for (const std::size_t number : loads) {
    plan.scenes.push_back(other_load(number));
    names.push_back("scene_" + std::to_string(number));
  }
  plan.candidates = {point.candidate};
  if (left_s() <= 0.0) return true;
  progress_.show_long("confirms " + point.candidate.name());
  prepare_references(names);
  if (left_s() <= 0.0) return true;
  run(plan, left_s());
  const FitPoint again = read(plan).front();
  const bool is_cut_short = left_s() <= 0.0 || is_interrupted_;
  if (again.failure.empty()) {
    point.error.insert(point.error.end(), again.error.begin() + 1, again.error.end());
    point.own_error.insert(point.own_error.end(), again.own_error.begin() + 1, again.own_error.end());
    point.confirmed_on = loads;
    point.looked_at = looked_at;
  } else if (!is_cut_short) {
    point.failure = "on further loads: " + again.failure;
  }
  return why_not(point, require_).empty();
}

void FitStages::look_for_stop() {
  if (options_.stop_flag == nullptr || *options_.stop_flag == 0) return;
  is_interrupted_ = true;
  is_complete_ = false;
}

}  // namespace palpate::experiments

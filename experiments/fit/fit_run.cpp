#include "experiments/fit/fit_run.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <numeric>
#include <optional>

#include "core/base/error.h"
#include "core/base/stopwatch.h"
#include "experiments/files/output_file.h"
#include "experiments/fit/candidates/fit_prospects.h"
#include "experiments/fit/fit_freeze.h"
#include "experiments/fit/fit_motions.h"
#include "experiments/fit/fit_search.h"
#include "experiments/processes/deadline.h"
#include "experiments/processes/machine_load.h"
#include "experiments/records/record_file.h"
#include "experiments/runner/read_plan.h"
#include "experiments/runner/runner.h"
#include "experiments/runner/side_by_side.h"
#include "experiments/scene_reader/scene_problem.h"
#include "experiments/trials/motion_trial.h"

namespace palpate::experiments {
namespace fs = std::filesystem;
namespace {

using nlohmann::json;

constexpr double kSearchShare = 0.6;  ///< of the time limit
constexpr std::size_t kFinalists = 4;
constexpr int kMostReferences = 2;  ///< at a time: each takes up to 3 GB
constexpr std::size_t kMostRounds = 4;
constexpr int kTimingRepeats = 5;
constexpr double kStillShare = 0.1;     ///< of the time limit: no still part is looked for with less
constexpr double kLookingShare = 0.85;  ///< of the time limit: then no cheaper one is looked for any more
constexpr double kFurtherShare = 0.3;   ///< of what is left: then no further loads are looked at any more
constexpr double kTimingShare = 0.15;   ///< of what is left: then nothing is timed again any more
constexpr double kWorthChecking = 0.9;  ///< of the cost of what is verified: a smaller gain is within noise

class Fit {
 public:
  Fit(const FitOptions& options, const Registry& registry, Progress& progress)
      : options_(options), registry_(registry), progress_(progress) {
    result_.scene = read_scene(options.scene);
    if (!result_.scene.require)
      throw InputError(options.scene.string() +
                       ": the key \"require\" is missing: what is the model to reach? At least require: "
                       "{error: {measure: deformation_l2, at_most: 0.05}}");
    candidates_ =
        read_candidates(options.candidates.empty() ? candidates_path() : options.candidates, registry);
    result_.work = choose_work(result_.scene);
  }

  FitResult run() {
    constexpr double kGradingShare = 0.5;  // of the search's time, up to which graded meshes are prepared
    const double grading_s = kGradingShare * kSearchShare * options_.time_limit_s;
    FitSearch planned =
        plan_search({options_.out, result_.scene, result_.work, grading_s, is_stepped(), options_.stop_flag},
                    registry_, progress_, candidates_);
    others_ = std::move(planned.others);
    result_.dropped = std::move(planned.dropped);
    result_.is_complete = planned.is_complete;
    const FitPlan search = std::move(planned.plan);
    prepare_references(search, {"scene_0", "scene_1"});
    progress_.show_long("search: " + std::to_string(search.candidates.size()) + " candidates");
    run_stage(search, kSearchShare * options_.time_limit_s - watch_.seconds());
    result_.searched = read_stage(search);
    result_.run = search.folder / "run";
    if (!result_.is_interrupted && is_stepped()) check_in_motion(search);
    if (!result_.is_interrupted && !is_stepped()) check_at_rest(search);
    if (!result_.choice && !result_.nearest) {
      if (const FitPoint* nearest = find_nearest(result_.searched, require())) result_.nearest = *nearest;
      result_.run = search.folder / "run";
    }
    if (options_.stop_flag != nullptr && *options_.stop_flag != 0) {  // in whatever it was
      result_.is_interrupted = true;
      result_.is_complete = false;
    }
    result_.wall_s = watch_.seconds();
    return std::move(result_);
  }

 private:
  const SceneRequirement& require() const { return *result_.scene.require; }

  /// Has the references of some scenes solved side by side, where there is more than one processor: they are
  /// most of what a fit waits for. scene_0 is the scene itself, scene_k the k-th of the other loads.
  void prepare_references(const FitPlan& search, const std::vector<std::string>& scenes) {
    SideBySide setting;
    setting.jobs = std::min(usable_processors(), kMostReferences);
    if (setting.jobs < 2 || left_s() <= 0.0) return;
    progress_.show_long("references");
    FitPlan plan = search;
    plan.folder = options_.out / "references";
    plan.candidates.resize(1);
    plan.scenes.insert(plan.scenes.end(), others_.begin(), others_.end());
    setting.plan = write_fit_plan(plan, candidates_);
    setting.folder = plan.folder / "runs";
    const Deadline deadline(left_s(), options_.stop_flag);
    setting.stop_flag = deadline.flag();
    prepare_side_by_side(scenes, setting);
  }

  void run_stage(const FitPlan& fit_plan, double seconds) {
    const fs::path file = write_fit_plan(fit_plan, candidates_);
    const Plan plan = read_plan(file, registry_);
    require_available(plan, registry_);
    const Deadline deadline(seconds, options_.stop_flag);
    RunOptions options;
    options.folder = fit_plan.folder / "run";
    options.stop_flag = deadline.flag();
    if (run_plan(plan, registry_, options, progress_).interrupted) {
      result_.is_complete = false;
      result_.is_interrupted = options_.stop_flag != nullptr && *options_.stop_flag != 0;
    }
  }

  /// A stage that may come to its end early: the fit is no less complete for it.
  void run_short_stage(const FitPlan& fit_plan, double seconds) {
    const bool was_complete = result_.is_complete;
    run_stage(fit_plan, seconds);
    if (!result_.is_interrupted) result_.is_complete = was_complete;
  }

  std::vector<FitPoint> read_stage(const FitPlan& plan) const {
    const fs::path records = plan.folder / "run" / "records.jsonl";
    if (!fs::exists(records)) return read_fit_points({}, plan, require());
    return read_fit_points(read_records(records), plan, require());
  }

  /// A check of some candidates on the scene and on the other loads that decide.
  FitPlan plan_check(const FitPlan& search, std::size_t other_loads) {
    FitPlan plan = search;
    plan.folder = options_.out / ("check_" + std::to_string(checks_++));
    plan.measures_answers = false;
    plan.candidates.clear();
    const auto last = others_.begin() + static_cast<std::ptrdiff_t>(other_loads);
    plan.scenes.insert(plan.scenes.end(), others_.begin(), last);
    return plan;
  }

  /// A scene at rest: rounds of what is worth a check, the cheapest first, until nothing cheaper than what is
  /// verified is left, or no time; then loads that no choice was made by. What those refuse is over the
  /// tolerance, so that all dearer ones are worth a check again.
  void check_at_rest(const FitPlan& search) {
    while (left_s() > 0.0 && !result_.is_interrupted) {
      const FitPoint* best = find_verified();
      const double most_cost = best == nullptr
                                   ? std::numeric_limits<double>::infinity()
                                   : kWorthChecking * lowered_cost(*best, result_.searched, result_.checked);
      const auto prospects =
          list_prospects(result_.searched, result_.checked, candidates_, require(), most_cost);
      const double looking_s = best == nullptr ? left_s() : left_s(kLookingShare);
      if (!prospects.empty() && looking_s > 0.0) {
        if (result_.checked.empty()) prepare_references(search, {"scene_2", "scene_3"});
        check(search, take_prospects(prospects, kFinalists, best != nullptr), looking_s);
        continue;
      }
      if (!prospects.empty()) result_.is_complete = false;
      if (best == nullptr || confirm(search, result_.checked[index_of(*best, result_.checked)])) break;
    }
    if (const FitPoint* best = find_verified()) {
      if (!best->is_confirmed()) best = find_safest(*best, result_.checked, require());
      result_.choice = *best;
      result_.run = runs_.at(plan_label(best->candidate));
    } else if (const FitPoint* nearest = find_nearest(result_.checked, require())) {
      result_.nearest = *nearest;
      result_.run = runs_.at(plan_label(nearest->candidate));
    }
  }

  /// The cheapest of what was checked that meets everything on all loads that it was run on, as far as others
  /// of its model say nothing else of further ones; null: none.
  const FitPoint* find_verified() const {
    for (const FitPoint* good : choose_cheapest(result_.checked, require())) {
      if (why_not_chosen(*good, result_.checked, require()).empty()) return good;
    }
    return nullptr;
  }

  /// Runs candidates on the scene and on the other loads. One that the time was not enough for is not
  /// looked at again.
  void check(const FitPlan& search, std::vector<FitCandidate> candidates, double seconds) {
    FitPlan plan = plan_check(search, kOtherLoads);
    plan.candidates = std::move(candidates);
    const std::vector<FitPoint> points = run_check(plan, seconds);
    for (const FitPoint& point : points) runs_[plan_label(point.candidate)] = plan.folder / "run";
    result_.checked.insert(result_.checked.end(), points.begin(), points.end());
  }

  /// Runs a check; costs are medians where there is time for them.
  std::vector<FitPoint> run_check(const FitPlan& plan, double seconds) {
    progress_.show_long("checks " + names_of(plan.candidates));
    run_stage(plan, seconds);
    std::vector<FitPoint> points = read_stage(plan);
    time_again(plan, points);
    return points;
  }

  static std::string names_of(const std::vector<FitCandidate>& candidates) {
    std::string text;
    for (const FitCandidate& each : candidates) text += (text.empty() ? "" : "; ") + each.name();
    return text;
  }

  /// Numbers of the further loads on which a candidate is the farthest off, the worst first, against
  /// quadratic elements on the scene's own mesh: that tells which, in a fraction of the time. Loads that
  /// there was no time for come last, in their order. `looked_at` is told how many were looked at.
  std::vector<std::size_t> rank_further_loads(const FitPlan& search, const FitCandidate& candidate,
                                              std::size_t& looked_at) {
    FitPlan plan = search;
    plan.folder = options_.out / ("look_" + std::to_string(looks_++));
    plan.levels = 1;
    plan.measures_answers = false;
    plan.work = FitWork::kFirst;  // nothing is timed
    plan.candidates = {candidate};
    plan.scenes.assign(others_.begin() + kOtherLoads, others_.end());
    progress_.show_long("looks for the loads on which " + candidate.name() + " is the farthest off");
    run_short_stage(plan, kFurtherShare * left_s());  // fewer loads are no fault
    const fs::path records = plan.folder / "run" / "records.jsonl";
    std::vector<std::optional<double>> errors(kFurtherLoads);
    if (fs::exists(records)) errors = read_errors(read_records(records), plan, require(), candidate);
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

  /// Runs the choice on the worst of the further loads; its errors there count like the others. True if it
  /// holds, or if no time is left to tell; FitPoint::error says how many loads it was run on.
  bool confirm(const FitPlan& search, FitPoint& point) {
    if (point.error.size() > 1 + kOtherLoads || left_s() <= 0.0) return true;
    std::size_t looked_at = 0;
    std::vector<std::size_t> loads = rank_further_loads(search, point.candidate, looked_at);
    loads.resize(kConfirmingLoads);
    FitPlan plan = plan_check(search, 0);
    std::vector<std::string> names;
    for (const std::size_t number : loads) {
      plan.scenes.push_back(others_[number - 1]);
      names.push_back("scene_" + std::to_string(number));
    }
    plan.candidates = {point.candidate};
    if (left_s() <= 0.0) return true;
    progress_.show_long("confirms " + point.candidate.name());
    prepare_references(search, names);
    if (left_s() <= 0.0) return true;
    run_stage(plan, left_s());
    const FitPoint again = read_stage(plan).front();
    const bool is_cut_short = left_s() <= 0.0 || result_.is_interrupted;
    if (again.failure.empty()) {
      point.error.insert(point.error.end(), again.error.begin() + 1, again.error.end());
      point.own_error.insert(point.own_error.end(), again.own_error.begin() + 1, again.own_error.end());
      point.confirmed_on = loads;
      point.looked_at = looked_at;
    } else if (!is_cut_short) {
      point.failure = "on further loads: " + again.failure;
    }
    return why_not(point, require()).empty();
  }

  static std::size_t index_of(const FitPoint& point, const std::vector<FitPoint>& points) {
    return static_cast<std::size_t>(&point - points.data());
  }

  /// The cheapest of what meets everything, and does so on the loads that confirm it too; null: none does.
  const FitPoint* confirm_cheapest(const FitPlan& search, std::vector<FitPoint>& points) {
    for (const FitPoint* each : choose_cheapest(points, require())) {
      if (!why_not_chosen(*each, points, require()).empty()) continue;
      if (confirm(search, points[index_of(*each, points)])) return each;
    }
    return nullptr;
  }

  /// A scene that moves: the cheapest of the search, and the cheapest to step implicitly, some at a time, on
  /// more loads and in motion; the first round in which one meets the tolerance everywhere decides, and on
  /// the loads that confirm it.
  void check_in_motion(const FitPlan& search) {
    std::vector<const FitPoint*> good = choose_cheapest(result_.searched, without_budget());
    if (!good.empty()) prepare_references(search, {"scene_2", "scene_3"});
    for (std::size_t round = 0; !good.empty() && round < kMostRounds; ++round) {
      if (left_s() <= 0.0) break;
      FitPlan plan = plan_check(search, kOtherLoads);
      const FitPoint* modal = take_modal_finalist(good, require().at_most);
      std::vector<const FitPoint*> others;
      std::copy_if(good.begin(), good.end(), std::back_inserter(others),
                   [](const FitPoint* point) { return !is_modal(point->candidate); });
      for (const FitPoint* finalist : take_finalists(others, kFinalists)) {
        plan.candidates.push_back(finalist->candidate);
        good.erase(std::find(good.begin(), good.end(), finalist));
      }
      if (modal != nullptr) plan.candidates.push_back(modal->candidate);
      std::vector<FitPoint> points = run_check(plan, left_s());
      if (!step_motions(motion_search(), plan, registry_, progress_, points)) result_.is_complete = false;
      if (const FitPoint* best = confirm_cheapest(search, points)) {
        result_.choice = *best;
        result_.run = plan.folder / "run";
        freeze(plan);
      }
      result_.checked.insert(result_.checked.end(), points.begin(), points.end());
      if (result_.choice || result_.is_interrupted) return;
      if (const auto dear = choose_cheapest(points, without_budget()); !dear.empty()) {
        result_.nearest = *dear.front();  // the tolerance is met: those that follow are dearer
        result_.run = plan.folder / "run";
        return;
      }
    }
  }

  /// Holds still what hardly moves of the choice, if that is cheaper and within the tolerance.
  void freeze(FitPlan check) {
    FitPoint& choice = *result_.choice;
    for (const std::size_t number : choice.confirmed_on) check.scenes.push_back(others_[number - 1]);
    if (!choice.stepping || is_modal(choice.candidate)) return;
    if (left_s() <= kStillShare * options_.time_limit_s) return;
    progress_.show_long("still parts of " + choice.candidate.name());
    const Scene placed = place_scene(result_.scene, build_scene_mesh(result_.scene.mesh).mesh);
    FreezeTask task;
    task.check = check;
    task.scene = build_fitted_scene(placed, choice.candidate.model);
    choice.stepping->stepping.apply(choice.stepping->step_s, task.scene);
    task.probes_m =
        choose_probes(result_.scene, result_.run / "problems" / choice.mesh / "in.mesh", kTrialProbes);
    task.folder = options_.out / "still";
    task.at_most = require().at_most;
    task.measure = require().measure;
    task.time_limit_s = left_s();
    task.stop_flag = options_.stop_flag;
    task.run = [this](const FitPlan& plan, double seconds) { run_stage(plan, seconds); };
    const bool was_complete = result_.is_complete;
    const std::string run_mesh = choice.mesh;
    result_.frozen = freeze_still_part(task, registry_, choice);
    result_.is_complete = was_complete;  // a saving that was not looked at to its end is none, and no fault
    choice.mesh = run_mesh;
    if (!result_.frozen.empty() && result_.frozen.back().why_not.empty())
      result_.frozen_file = task.folder / "frozen.json";
  }

  /// Whether integrators are tried: a preset has its own, and a scene at rest has none.
  bool is_stepped() const {
    return result_.work == FitWork::kSecond && result_.scene.is_dynamic &&
           result_.scene.dynamic.preset.empty() && !candidates_.steppings.empty();
  }

  /// The tolerance without the budget, which the explicit steps of the search say nothing of.
  const SceneRequirement& without_budget() {
    if (!without_budget_) {
      without_budget_ = require();
      without_budget_->time_per_second_s.reset();
    }
    return *without_budget_;
  }

  MotionSearch motion_search() {
    const Scene& scene = result_.scene;
    return {scene,
            place_scene(scene, build_scene_mesh(scene.mesh).mesh),
            candidates_.steppings,
            without_budget(),
            options_.time_limit_s,
            [this] { return left_s(); },
            options_.stop_flag};
  }

  /// Runs those that meet the tolerance some times more on the scene itself: which is the cheapest is told by
  /// medians. Without the time for it, what was measured before stands.
  void time_again(const FitPlan& check, std::vector<FitPoint>& points) {
    FitPlan plan = check;
    plan.folder = check.folder / "timing";
    plan.repeats = kTimingRepeats;
    plan.scenes.resize(1);
    plan.candidates.clear();
    for (const FitPoint* point : choose_cheapest(points, require()))
      plan.candidates.push_back(point->candidate);
    if (plan.candidates.empty() || left_s() <= 0.0) return;
    run_short_stage(plan, kTimingShare * left_s());  // nor are fewer times: a choice is to be confirmed yet
    for (const FitPoint& timed : read_stage(plan)) {
      const FitCandidate& own = timed.candidate;
      for (FitPoint& point : points) {
        const bool is_same = plan_label(point.candidate) == plan_label(own);
        if (is_same && timed.failure.empty() && !timed.cost_s.empty()) point.cost_s = timed.cost_s;
      }
    }
  }

  /// Until a share of the time limit is over.
  double left_s(double share = 1.0) const { return share * options_.time_limit_s - watch_.seconds(); }

  const FitOptions& options_;
  const Registry& registry_;
  Progress& progress_;
  Stopwatch watch_;
  FitCandidates candidates_;
  std::vector<json> others_;  ///< the scene under the other loads, 1, 2, ...
  std::size_t checks_ = 0;    ///< each has a folder
  std::size_t looks_ = 0;
  std::map<std::string, fs::path> runs_;  ///< of what was checked at rest, by its label
  std::optional<SceneRequirement> without_budget_;
  FitResult result_;
};

}  // namespace

FitResult run_fit(const FitOptions& options, const Registry& registry, Progress& progress) {
  std::error_code error;
  if (fs::exists(options.out, error) && !fs::is_empty(options.out, error))
    throw InputError(options.out.string(), 0, "a new or an empty folder", "one that holds something");
  Fit fit(options, registry, progress);
  create_folder(options.out);
  return fit.run();
}

}  // namespace palpate::experiments

#include "experiments/fit/fit_run.h"

#include <algorithm>
#include <iterator>
#include <limits>
#include <map>
#include <optional>

#include "core/base/error.h"
#include "experiments/files/output_file.h"
#include "experiments/fit/candidates/fit_prospects.h"
#include "experiments/fit/fit_freeze.h"
#include "experiments/fit/fit_motions.h"
#include "experiments/fit/fit_search.h"
#include "experiments/fit/fit_stages.h"
#include "experiments/scene_reader/scene_problem.h"
#include "experiments/trials/motion_trial.h"

namespace palpate::experiments {
namespace fs = std::filesystem;
namespace {

constexpr double kSearchShare = 0.6;  ///< of the time limit
constexpr std::size_t kFinalists = 4;
constexpr std::size_t kMostRounds = 4;
constexpr double kStillShare = 0.1;     ///< of the time limit: no still part is looked for with less
constexpr double kLookingShare = 0.85;  ///< of the time limit: then no cheaper one is looked for any more
constexpr double kWorthChecking = 0.9;  ///< of the cost of what is verified: a smaller gain is within noise

FitResult begin_fit(const FitOptions& options) {
  FitResult begun;
  begun.scene = read_scene(options.scene);
  if (!begun.scene.require)
    throw InputError(options.scene.string() +
                     ": the key \"require\" is missing: what is the model to reach? At least require: "
                     "{error: {measure: deformation_l2, at_most: 0.05}}");
  begun.work = choose_work(begun.scene);
  return begun;
}

class Fit {
 public:
  Fit(const FitOptions& options, const Registry& registry, Progress& progress)
      : options_(options),
        registry_(registry),
        progress_(progress),
        result_(begin_fit(options)),
        candidates_(
            read_candidates(options.candidates.empty() ? candidates_path() : options.candidates, registry)),
        stages_(options, registry, progress, require(), candidates_) {}

  FitResult run() {
    constexpr double kGradingShare = 0.5;  // of the search's time, up to which graded meshes are prepared
    const double grading_s = kGradingShare * kSearchShare * options_.time_limit_s;
    FitSearch planned =
        plan_search({options_.out, result_.scene, result_.work, grading_s, is_stepped(), options_.stop_flag},
                    registry_, progress_, candidates_);
    result_.dropped = std::move(planned.dropped);
    if (!planned.is_complete) stages_.note_left_out();
    stages_.begin(std::move(planned.plan), std::move(planned.others));
    search();
    if (!stages_.is_interrupted() && is_stepped()) check_in_motion();
    if (!stages_.is_interrupted() && !is_stepped()) check_at_rest();
    if (!result_.choice && !result_.nearest) {
      if (const FitPoint* nearest = find_nearest(result_.searched, require())) result_.nearest = *nearest;
      result_.run = stages_.search().folder / "run";
    }
    stages_.look_for_stop();  // in whatever it was
    result_.is_complete = stages_.is_complete();
    result_.is_interrupted = stages_.is_interrupted();
    result_.wall_s = stages_.wall_s();
    return std::move(result_);
  }

 private:
  const SceneRequirement& require() const { return *result_.scene.require; }

  /// Every candidate on the scene itself.
  void search() {
    const FitPlan& search = stages_.search();
    stages_.prepare_references({"scene_0", "scene_1"});
    progress_.show_long("search: " + std::to_string(search.candidates.size()) + " candidates");
    stages_.run(search, stages_.left_s(kSearchShare));
    result_.searched = stages_.read(search);
    result_.run = search.folder / "run";
  }

  /// A scene at rest: rounds of what is worth a check, the cheapest first, until nothing cheaper than what is
  /// verified is left, or no time; then loads that no choice was made by. What those refuse is over the
  /// tolerance, so that all dearer ones are worth a check again.
  void check_at_rest() {
    while (stages_.left_s() > 0.0 && !stages_.is_interrupted()) {
      const FitPoint* best = find_verified();
      const double most_cost = best == nullptr
                                   ? std::numeric_limits<double>::infinity()
                                   : kWorthChecking * lowered_cost(*best, result_.searched, result_.checked);
      const auto prospects =
          list_prospects(result_.searched, result_.checked, candidates_, require(), most_cost);
      const double looking_s = stages_.left_s(best == nullptr ? 1.0 : kLookingShare);
      if (!prospects.empty() && looking_s > 0.0) {
        if (result_.checked.empty()) stages_.prepare_references({"scene_2", "scene_3"});
        check(take_prospects(prospects, kFinalists, best != nullptr), looking_s);
        continue;
      }
      if (!prospects.empty()) stages_.note_left_out();
      if (best == nullptr || stages_.confirm(result_.checked[index_of(*best, result_.checked)])) break;
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
  void check(std::vector<FitCandidate> candidates, double seconds) {
    FitPlan plan = stages_.plan_check();
    plan.candidates = std::move(candidates);
    const std::vector<FitPoint> points = stages_.run_check(plan, seconds);
    for (const FitPoint& point : points) runs_[plan_label(point.candidate)] = plan.folder / "run";
    result_.checked.insert(result_.checked.end(), points.begin(), points.end());
  }

  static std::size_t index_of(const FitPoint& point, const std::vector<FitPoint>& points) {
    return static_cast<std::size_t>(&point - points.data());
  }

  /// The cheapest of what meets everything, and does so on the loads that confirm it too; null: none does.
  const FitPoint* confirm_cheapest(std::vector<FitPoint>& points) {
    for (const FitPoint* each : choose_cheapest(points, require())) {
      if (!why_not_chosen(*each, points, require()).empty()) continue;
      if (stages_.confirm(points[index_of(*each, points)])) return each;
    }
    return nullptr;
  }

  /// A scene that moves: the cheapest of the search, and the cheapest to step implicitly, some at a time, on
  /// more loads and in motion; the first round in which one meets the tolerance everywhere decides, and on
  /// the loads that confirm it.
  void check_in_motion() {
    std::vector<const FitPoint*> good = choose_cheapest(result_.searched, without_budget());
    if (!good.empty()) stages_.prepare_references({"scene_2", "scene_3"});
    for (std::size_t round = 0; !good.empty() && round < kMostRounds; ++round) {
      if (stages_.left_s() <= 0.0) break;
      FitPlan plan = stages_.plan_check();
      const FitPoint* modal = take_modal_finalist(good, require().at_most);
      std::vector<const FitPoint*> others;
      std::copy_if(good.begin(), good.end(), std::back_inserter(others),
                   [](const FitPoint* point) { return !is_modal(point->candidate); });
      for (const FitPoint* finalist : take_finalists(others, kFinalists)) {
        plan.candidates.push_back(finalist->candidate);
        good.erase(std::find(good.begin(), good.end(), finalist));
      }
      if (modal != nullptr) plan.candidates.push_back(modal->candidate);
      std::vector<FitPoint> points = stages_.run_check(plan, stages_.left_s());
      if (!step_motions(motion_search(), plan, registry_, progress_, points)) stages_.note_left_out();
      if (const FitPoint* best = confirm_cheapest(points)) {
        result_.choice = *best;
        result_.run = plan.folder / "run";
        freeze(plan);
      }
      result_.checked.insert(result_.checked.end(), points.begin(), points.end());
      if (result_.choice || stages_.is_interrupted()) return;
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
    for (const std::size_t number : choice.confirmed_on) check.scenes.push_back(stages_.other_load(number));
    if (!choice.stepping || is_modal(choice.candidate)) return;
    if (stages_.left_s() <= kStillShare * options_.time_limit_s) return;
    progress_.show_long("still parts of " + choice.candidate.name());
    const Scene placed = place_scene(result_.scene, build_scene_mesh(result_.scene.mesh).mesh);
    FreezeTask task;
    task.check = check;
    task.scene =
        build_fitted_scene(placed, choice.candidate.model, whole_mesh_of(choice.candidate, result_.run));
    choice.stepping->stepping.apply(choice.stepping->step_s, task.scene);
    task.probes_m =
        choose_probes(result_.scene, result_.run / "problems" / choice.mesh / "in.mesh", kTrialProbes);
    task.folder = options_.out / "still";
    task.at_most = require().at_most;
    task.measure = require().measure;
    task.time_limit_s = stages_.left_s();
    task.stop_flag = options_.stop_flag;
    // A saving that was not looked at to its end is none, and no fault.
    task.run = [this](const FitPlan& plan, double seconds) { stages_.run_short(plan, seconds); };
    const std::string run_mesh = choice.mesh;
    result_.frozen = freeze_still_part(task, registry_, choice);
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
            [this] { return stages_.left_s(); },
            options_.stop_flag};
  }

  const FitOptions& options_;
  const Registry& registry_;
  Progress& progress_;
  FitResult result_;
  FitCandidates candidates_;
  FitStages stages_;
  std::map<std::string, fs::path> runs_;  ///< of what was checked at rest, by its label
  std::optional<SceneRequirement> without_budget_;
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

// The runs of a fit, one after another within its time: each is a plan of the contest deform in a folder of
// its own.
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/base/stopwatch.h"
#include "experiments/fit/candidates/fit_points.h"
#include "experiments/fit/fit_options.h"
#include "experiments/fit/fit_search.h"
#include "experiments/text/terminal.h"

namespace palpate::experiments {

/// Runs what a fit asks for and reads what came of it. Its clock starts when it is made.
class FitStages {
 public:
  /// All of them outlive it; `candidates` may change until begin().
  FitStages(const FitOptions& options, const Registry& registry, Progress& progress,
            const SceneRequirement& require, const FitCandidates& candidates)
      : options_(options),
        registry_(registry),
        progress_(progress),
        require_(require),
        candidates_(candidates) {}

  /// What is searched on the scene itself, and the scene under the other loads (numbers 1, 2, ...).
  void begin(FitPlan search, std::vector<nlohmann::json> others);

  const FitPlan& search() const { return search_; }

  /// Seconds until a share of the time limit is over.
  double left_s(double share = 1.0) const;
  double wall_s() const { return watch_.seconds(); }

  /// Has the references of some scenes solved side by side, where there is more than one processor: they are
  /// most of what a fit waits for. scene_0 is the scene itself, scene_k the k-th of the other loads.
  void prepare_references(const std::vector<std::string>& scenes);

  /// Throws: as run_plan.
  void run(const FitPlan& plan, double seconds);

  /// A run that may come to its end early: the fit is no less complete for it.
  void run_short(const FitPlan& plan, double seconds);

  /// What was run of the plan's candidates, in their order.
  std::vector<FitPoint> read(const FitPlan& plan) const;

  /// A check of some candidates, which are to be added, on the scene and on all other loads that decide.
  FitPlan plan_check() { return plan_check(kOtherLoads); }

  /// Runs a check; costs are medians where there is time for them.
  std::vector<FitPoint> run_check(const FitPlan& plan, double seconds);

  /// Runs the choice on the worst of the further loads; its errors there count like the others. True if it
  /// holds, or if no time is left to tell; FitPoint::error says how many loads it was run on.
  bool confirm(FitPoint& point);

  /// A further load as a plan has it.
  const nlohmann::json& other_load(std::size_t number) const { return others_[number - 1]; }

  bool is_complete() const { return is_complete_; }        ///< nothing was left out
  bool is_interrupted() const { return is_interrupted_; }  ///< by the user

  /// Something was left out for want of time.
  void note_left_out() { is_complete_ = false; }

  /// Notes whether the user wants it to end.
  void look_for_stop();

 private:
  FitPlan plan_check(std::size_t other_loads);
  void time_again(const FitPlan& check, std::vector<FitPoint>& points);
  std::vector<std::size_t> rank_further_loads(const FitCandidate& candidate, std::size_t& looked_at);

  const FitOptions& options_;
  const Registry& registry_;
  Progress& progress_;
  const SceneRequirement& require_;
  const FitCandidates& candidates_;
  Stopwatch watch_;
  FitPlan search_;
  std::vector<nlohmann::json> others_;
  std::size_t checks_ = 0;  ///< each has a folder
  std::size_t looks_ = 0;
  bool is_complete_ = true;
  bool is_interrupted_ = false;
};

}  // namespace palpate::experiments

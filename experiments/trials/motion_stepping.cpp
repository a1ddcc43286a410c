#include "experiments/trials/motion_stepping.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/base/error.h"
#include "core/base/stopwatch.h"
#include "core/dynamics/motion/integrator_kind.h"
#include "experiments/processes/deadline.h"
#include "experiments/trials/motion_trial.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;

constexpr double kLongestShare = 1.0 / 20.0;  ///< of the duration: an implicit step
constexpr double kLeastGain = 2.0;            ///< explicit steps: a shorter implicit one can gain nothing
constexpr double kShortestExplicit = 0.25;    ///< of the scene's own
constexpr double kTruthShare = 0.4;           ///< of the time
constexpr int kTimings = 3;
constexpr double kLongRun = 5.0;       ///< s: is not run again to be timed
constexpr double kPatience = 1.5;      ///< times the cheapest: a run that takes longer is cut short
constexpr double kLeastTimeout = 2.0;  ///< s
constexpr double kNever = std::numeric_limits<double>::infinity();

bool is_explicit(const FitStepping& stepping) {
  return !is_implicit(dynamics::parse_integrator(stepping.integrator));
}

class SteppingTrials {
 public:
  SteppingTrials(const SteppingTask& task, const Registry& registry)
      : task_(task),
        registry_(registry),
        deadline_(task.time_limit_s, task.stop_flag),
        duration_s_(task.scene.at("/analysis/dynamic/duration_s"_json_pointer).get<double>()) {}

  std::vector<SteppingTry> run(const std::vector<FitStepping>& steppings) {
    std::vector<SteppingTry> tries;
    if (const std::string why = find_truth(); !why.empty()) {
      for (const FitStepping& stepping : steppings) {
        tries.emplace_back().stepping = stepping;
        tries.back().why_not = "not tried: its motion " + why + " before it had a step";
      }
      return tries;
    }
    for (const FitStepping& stepping : steppings) {
      const SteppingTry* best = choose_stepping(tries);
      cheapest_s_ = best != nullptr ? best->cost() : kNever;
      tries.push_back(try_one(stepping));
    }
    return tries;
  }

 private:
  double left_s() const { return task_.time_limit_s - watch_.seconds(); }

  SteppingTry try_one(const FitStepping& stepping) {
    SteppingTry tried;
    tried.stepping = stepping;
    tried.why_not = "not tried: no time was left";
    if (left_s() <= 0.0) return tried;
    const bool by_bound = is_explicit(stepping);
    tried = find_step(stepping, by_bound ? bound_s_ : kLongestShare * duration_s_,
                      (by_bound ? kShortestExplicit : kLeastGain) * bound_s_, task_.most_error, cheapest_s_,
                      [&](double step_s) { return look_at(stepping, step_s); });
    tried.is_auto = by_bound && tried.step_s == bound_s_;
    const bool is_long = tried.cost() * duration_s_ > kLongRun;
    for (int k = 1; k < kTimings && tried.why_not.empty() && !is_long && left_s() > 0.0; ++k) {
      const MotionTrial again = step(stepping, tried.step_s, left_s());
      if (again.outcome == "completed") tried.cost_s.push_back(again.second_s());
    }
    return tried;
  }

  /// The scene's motion by explicit steps of its own choice, and in a quarter of them. Returns what it did
  /// before it had a step; empty if it had one.
  std::string find_truth() {
    const FitStepping plain{"", kExplicitIntegrator, false, nullptr};
    json scene = task_.scene;
    scene = with_fixed_step(scene, 1.0, task_.probes_m);
    scene["analysis"]["dynamic"].erase("allow_unstable");
    plain.apply("auto", scene);
    MotionTrial own;
    try {
      own = run_motion_trial(scene, next_trial(kTruthShare * left_s()), registry_);
    } catch (const InputError& error) {
      return std::string("was refused (") + error.what() + ")";  // by the engine: the scene was read before
    }
    bound_s_ = own.step_s;
    if (!(bound_s_ > 0.0)) return *deadline_.flag() != 0 ? "was stopped" : "ended as " + own.outcome;
    if (own.outcome != "completed" || own.kernel_s / kFinerStep > kTruthShare * left_s()) return "";
    MotionTrial fine = step(plain, kFinerStep * bound_s_, kTruthShare * left_s());
    if (fine.outcome != "completed") return "";
    rest_of_truth_ = history_difference(own.history, fine.history) / 3.0;
    truth_ = std::move(fine.history);
    return "";
  }

  SteppedMotion look_at(const FitStepping& stepping, double step_s) {
    SteppedMotion found;
    found.cost_s = kNever;
    try {
      const MotionTrial motion = step(stepping, step_s, most_seconds());
      found.memory_bytes = motion.memory_bytes;
      found.ending = over_memory(motion.memory_bytes, task_.memory_bytes);
      if (!found.ending.empty()) return found;  // shorter steps take as much
      if (motion.simulated_s > 0.0) found.cost_s = motion.second_s();
      if (motion.outcome != "completed") {
        found.ending = motion.outcome;
      } else if (truth_) {
        found.error = history_difference(motion.history, *truth_) + rest_of_truth_;
      } else {
        const MotionTrial fine = step(stepping, kFinerStep * step_s, left_s());
        if (fine.outcome != "completed")
          found.ending = fine.outcome + " with a quarter of the step";
        else
          found.error = kRestOfOrderOne * history_difference(motion.history, fine.history);
      }
      if (found.error && !std::isfinite(*found.error)) found.ending = "not finite";
    } catch (const InputError& error) {
      found.ending = error.what();  // an engine that does not take the model, say
    }
    return found;
  }

  /// What a run may take: one that is dearer than the cheapest by far need not come to its end.
  double most_seconds() const {
    if (!std::isfinite(cheapest_s_)) return std::max(left_s(), kLeastTimeout);
    return std::clamp(kPatience * cheapest_s_ * duration_s_, kLeastTimeout,
                      std::max(left_s(), kLeastTimeout));
  }

  MotionTrial step(const FitStepping& stepping, double step_s, double timeout_s) {
    json scene = task_.scene;
    stepping.apply(step_s, scene);
    return run_motion_trial(with_fixed_step(scene, step_s, task_.probes_m), next_trial(timeout_s), registry_);
  }

  TrialSettings next_trial(double timeout_s) {
    TrialSettings settings;
    settings.mesh = task_.mesh;
    settings.folder = task_.folder / std::to_string(trials_++);
    settings.timeout_s = std::max(timeout_s, kLeastTimeout);
    settings.stop_flag = deadline_.flag();
    return settings;
  }

  const SteppingTask& task_;
  const Registry& registry_;
  Deadline deadline_;
  Stopwatch watch_;
  double duration_s_;
  double bound_s_ = 0.0;  ///< the explicit step of the scene's own choice
  std::optional<ProbeHistory> truth_;
  double rest_of_truth_ = 0.0;  ///< what it leaves itself
  double cheapest_s_ = kNever;
  std::size_t trials_ = 0;
};

}  // namespace

std::vector<SteppingTry> try_steppings(const SteppingTask& task, const std::vector<FitStepping>& steppings,
                                       const Registry& registry) {
  return SteppingTrials(task, registry).run(steppings);
}

}  // namespace palpate::experiments

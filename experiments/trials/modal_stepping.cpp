#include "experiments/trials/modal_stepping.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/base/error.h"
#include "core/base/stopwatch.h"
#include "experiments/contests/moving_task.h"
#include "experiments/processes/deadline.h"
#include "experiments/scene_reader/scene_motion.h"
#include "experiments/text/figure_text.h"
#include "experiments/text/terminal.h"
#include "experiments/trials/motion_trial.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;

constexpr double kFirstSteps = 100.0;  ///< of the whole elements, over the duration
constexpr double kRestOfOrderTwo = 1.0 / 3.0;
constexpr double kTruthRoom = 0.25;  ///< of the error that may be left: elements that are so good do
constexpr double kWholeShare = 0.6;  ///< of the time, for the elements stepped whole
constexpr int kFurtherRuns = 3;

class ModalTrials {
 public:
  ModalTrials(const SteppingTask& task, const Registry& registry)
      : task_(task),
        registry_(registry),
        deadline_(task.time_limit_s, task.stop_flag),
        duration_s_(task.scene.at("/analysis/dynamic/duration_s"_json_pointer).get<double>()) {}

  std::vector<SteppingTry> run(const std::vector<FitStepping>& steppings) {
    std::vector<std::size_t> order(steppings.size());
    std::iota(order.begin(), order.end(), 0U);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return *steppings[a].modes < *steppings[b].modes; });
    std::vector<SteppingTry> tries(steppings.size());
    std::string why;
    try {
      why = find_truth(steppings.front());
    } catch (const InputError& error) {
      why = std::string("its motion was not verified: ") + error.what();
    }
    for (const std::size_t k : order) {
      tries[k].stepping = steppings[k];
      tries[k].step_s = step_s_;
      tries[k].why_not = why;
      if (!why.empty()) continue;
      try_one(tries[k]);
      if (tries[k].why_not.empty())
        why = "not tried: it has more modes than " + tries[k].stepping.label + ", which holds";
    }
    return tries;
  }

 private:
  double left_s() const { return task_.time_limit_s - watch_.seconds(); }

  TrialSettings next_trial(double timeout_s) {
    TrialSettings settings;
    settings.mesh = task_.mesh;
    settings.folder = task_.folder / std::to_string(trials_++);
    settings.timeout_s = std::max(timeout_s, 1.0);
    settings.stop_flag = deadline_.flag();
    settings.timings = kFurtherRuns;
    return settings;
  }

  json scene_with(const FitStepping& stepping, double step_s) const {
    json scene = task_.scene;
    stepping.apply(step_s, scene);
    return with_fixed_step(scene, step_s, task_.probes_m);
  }

  /// The elements stepped whole; empty rows and `why` where they do not come to their end.
  ProbeHistory step_whole(const FitStepping& any, double step_s, double timeout_s, std::string& why) {
    const TrialSettings settings = next_trial(timeout_s);
    const PlacedTrial placed = place_trial(scene_with(any, step_s), settings);
    const reference::MotionProblem problem = build_motion_problem(placed.scene, placed.mesh);
    const std::string method = whole_method(task_.scene.at("model"));
    ContestantTask task = start_task(method, reference::motion_to_json(problem), placed.mesh, registry_,
                                     settings.folder / "whole");
    task.options["time_step_s"] = step_s;
    task.timeout_s = settings.timeout_s;
    task.stop_flag = settings.stop_flag;
    const ContestantAnswer answer = run_contestant(task);
    const std::string outcome = answer.outcome == "ok" ? answer.report.value("outcome", "") : answer.outcome;
    if (outcome != "completed") {
      why = "its motion was not verified: " + method + " " + outcome + " in steps of " + time_text(step_s) +
            (answer.message.empty() ? "" : ": " + answer.message);
      return {};
    }
    return probes_of(reference::read_history(answer.output, problem));
  }

  static ProbeHistory probes_of(const reference::MotionHistory& history) {
    ProbeHistory out;
    for (const std::vector<double>& row : history.rows) {
      std::vector<double>& cells = out.row.emplace_back();
      for (std::size_t c = 0; c < row.size(); ++c) {
        if (history.columns[c] == "time_s") out.time_s.push_back(row[c]);
        if (history.columns[c].starts_with("probe_")) cells.push_back(row[c]);
      }
    }
    return out;
  }

  /// Why there is none; empty if there is.
  std::string find_truth(const FitStepping& any) {
    std::string why;
    const double most_s = kWholeShare * left_s();
    step_s_ = duration_s_ / kFirstSteps;
    truth_ = step_whole(any, step_s_, most_s, why);
    rest_of_truth_ = std::numeric_limits<double>::infinity();
    while (why.empty() && rest_of_truth_ > kTruthRoom * task_.most_error) {
      const Stopwatch watch;
      ProbeHistory finer = step_whole(any, 0.5 * step_s_, most_s - watch_.seconds(), why);
      if (!why.empty()) break;
      rest_of_truth_ = kRestOfOrderTwo * history_difference(truth_, finer);
      truth_ = std::move(finer);
      step_s_ *= 0.5;
      if (2.0 * watch.seconds() > most_s - watch_.seconds()) break;
    }
    if (rest_of_truth_ <= task_.most_error) return "";  // what came of a further halving or not
    if (!why.empty()) return why;
    return "its motion was not verified: the elements stepped whole in steps of " + time_text(step_s_) +
           " leave " + percent_text(rest_of_truth_) + " of it themselves";
  }

  void try_one(SteppingTry& tried) {
    if (left_s() <= 0.0) {
      tried.why_not = "not tried: no time was left";
      return;
    }
    try {
      const MotionTrial motion =
          run_motion_trial(scene_with(tried.stepping, step_s_), next_trial(left_s()), registry_);
      if (motion.outcome != "completed") {
        tried.why_not = motion.outcome;
        return;
      }
      tried.setup_s = motion.setup_s;
      tried.memory_bytes = motion.memory_bytes;
      tried.why_not = over_memory(motion.memory_bytes, task_.memory_bytes);
      if (!tried.why_not.empty()) return;
      for (const double kernel_s : motion.again_s) tried.cost_s.push_back(motion.second_of(kernel_s));
      tried.error = difference_at_rows(motion.history, truth_) + rest_of_truth_;
      if (!(*tried.error <= task_.most_error))
        tried.why_not = std::isfinite(*tried.error)
                            ? "leaves " + percent_text(*tried.error) + " of the motion"
                            : "its motion is not finite";
    } catch (const InputError& error) {
      tried.why_not = error.what();  // more modes than the body has, say
    } catch (const UnavailableError& error) {
      tried.why_not = error.what();  // modes that are not found
    }
  }

  const SteppingTask& task_;
  const Registry& registry_;
  Deadline deadline_;
  Stopwatch watch_;
  double duration_s_;
  double step_s_ = 0.0;
  ProbeHistory truth_;
  double rest_of_truth_ = 0.0;
  std::size_t trials_ = 0;
};

}  // namespace

std::string whole_method(const json& model) {
  return "moving_fem." + model.value("elements", "p2");
}

std::string why_no_modes(const Scene& scene, const std::vector<FitStepping>& steppings, const json& model_set,
                         const Registry& registry) {
  const SceneDynamic& dynamic = scene.dynamic;
  if (!scene.is_dynamic) return "the scene has no motion to verify them on";
  if (!dynamic.preset.empty()) return "the preset " + dynamic.preset + " has a model of its own";
  if (scene.strain == StrainSize::kLarge) return "they are linear, and the scene has large strain";
  if (dynamic.mass_per_vertex_kg) return "they have the material's masses, not mass_per_vertex_kg";
  if (dynamic.speed_limit_m_s) return "they know no speed_limit_m_s";
  if (dynamic.damping_spring_n_s_per_m > 0.0 || dynamic.damping_vertex_n_s_per_m > 0.0)
    return "they are damped by stiffness_s and mass_per_s alone";
  if (std::none_of(steppings.begin(), steppings.end(), [](const auto& one) { return one.modes; }))
    return "no stepping of the candidates says how many";
  const std::string method = whole_method(model_set);
  const auto entry = registry.find(method);
  const std::string why = entry ? entry->contestant->unavailable() : "there is no such method";
  return why.empty() ? "" : method + ", which their motion is held against, is unavailable: " + why;
}

std::vector<SteppingTry> try_modes(const SteppingTask& task, const std::vector<FitStepping>& steppings,
                                   const Registry& registry) {
  return ModalTrials(task, registry).run(steppings);
}

}  // namespace palpate::experiments

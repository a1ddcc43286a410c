#include "experiments/envelope/envelope_run.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/base/stopwatch.h"
#include "experiments/envelope/fitted_folder.h"
#include "experiments/files/file_hash.h"
#include "experiments/files/output_file.h"
#include "experiments/fit/candidates/fit_points.h"
#include "experiments/processes/deadline.h"
#include "experiments/records/record_file.h"
#include "experiments/runner/read_plan.h"
#include "experiments/runner/runner.h"
#include "experiments/trials/motion_trial.h"

namespace palpate::experiments {
namespace fs = std::filesystem;
namespace {

using nlohmann::json;

class Envelope {
 public:
  Envelope(const EnvelopeOptions& options, const Registry& registry, Progress& progress)
      : options_(options),
        registry_(registry),
        progress_(progress),
        deadline_(options.time_limit_s, options.stop_flag),
        fitted_(read_fitted_folder(options.folder)),
        work_(options.folder / "envelope") {
    std::error_code error;
    if (fs::exists(options.folder / "envelope.json", error))
      throw InputError(options.folder.string(), 0,
                       "a fit without an envelope (remove envelope.json to measure it anew)",
                       "envelope.json");
    fs::remove_all(work_, error);  // what an earlier one left that did not come to its end
    const fs::path mesh = options.folder / "organ.mesh";
    probes_m_ = choose_probes(read_scene(options.folder / "search" / "scene_0.yaml"), mesh, kTrialProbes);
    result_.mesh_hash = hash_file(mesh);
    result_.at_most = fitted_.at_most();
    result_.measure = fitted_.fit.at("measure").get<std::string>();
    result_.model = fitted_.scene.at("model");
    result_.scene = fitted_.scene;
    result_.axes = axes_of(fitted_.scene);
    is_moving_ = fitted_.scene.at("analysis").is_object();
  }

  EnvelopeResult run() {
    create_folder(work_);
    if (is_moving_) find_step();
    result_.place = place_of(is_moving_ ? fixed_ : fitted_.scene);
    const std::optional<EnvelopeProbe> at_one = look_at(std::nullopt, 1.0);
    if (at_one) {
      result_.at_one = *at_one;
      for (const EnvelopeAxis axis : result_.axes)
        result_.borders.push_back(find_border(
            *at_one, most_factor(axis), [&](double factor) { return look_at(axis, factor); },
            options_.resolution));
    }
    result_.is_interrupted = options_.stop_flag != nullptr && *options_.stop_flag != 0;
    result_.wall_s = watch_.seconds();
    return std::move(result_);
  }

 private:
  bool is_over() const { return *deadline_.flag() != 0; }

  /// The step that the fitted scene is run with; a step of its own choice depends on the body.
  void find_step() {
    progress_.show("the scene's own step");
    json scene = fitted_.scene;
    scene["analysis"]["dynamic"]["frames"] = 0;
    scene["analysis"]["dynamic"]["probes_m"] = probes_m_;
    const MotionTrial trial = run_motion_trial(scene, next_trial(), registry_);
    if (!(trial.step_s > 0.0))
      throw InputError(fitted_.scene_file().string() + ": the fitted scene's motion is " + trial.outcome +
                       " before it has a step");
    fixed_ = with_fixed_step(fitted_.scene, trial.step_s, probes_m_);
  }

  /// Nothing where it was stopped: what was cut short says nothing of the body.
  std::optional<EnvelopeProbe> look_at(std::optional<EnvelopeAxis> axis, double factor) {
    if (is_over()) return std::nullopt;
    progress_.show(axis ? std::string(axis_text(*axis)) + " " + three_digits(factor) : "the scene as it is");
    EnvelopeProbe probe;
    probe.factor = factor;
    if (is_moving_) look_at_motion(axis, factor, probe);
    if (probe.holds()) look_at_rest(axis, factor, probe);
    if (probe.holds() && probe.error() + probe.reference_error.value_or(0.0) > result_.at_most)
      probe.ending = kPassesTolerance;
    if (is_over() && !probe.holds()) return std::nullopt;
    return probe;
  }

  json at(const json& scene, std::optional<EnvelopeAxis> axis, double factor) const {
    return axis ? scaled_scene(scene, *axis, factor) : scene;
  }

  void look_at_motion(std::optional<EnvelopeAxis> axis, double factor, EnvelopeProbe& probe) {
    const json scene = at(fixed_, axis, factor);
    const MotionTrial coarse = run_motion_trial(scene, next_trial(), registry_);
    if (coarse.outcome != "completed") {
      probe.ending = coarse.outcome;
      return;
    }
    const json finer = scaled_scene(scene, EnvelopeAxis::kStep, kFinerStep);
    const MotionTrial fine = run_motion_trial(finer, next_trial(), registry_);
    if (fine.outcome != "completed") {
      probe.ending = fine.outcome;
      probe.message = "with a quarter of the step";
      return;
    }
    probe.step_error = kRestOfOrderOne * history_difference(coarse.history, fine.history);
    if (!std::isfinite(*probe.step_error)) probe.ending = "non_finite";
  }

  void look_at_rest(std::optional<EnvelopeAxis> axis, double factor, EnvelopeProbe& probe) {
    if (axis && !changes_rest(*axis, fitted_.rest_scene)) {
      probe.rest_error = result_.at_one.rest_error;
      probe.reference_error = result_.at_one.reference_error;
      return;
    }
    FitPlan plan;
    plan.folder = next_folder();
    plan.scenes = {at(fitted_.rest_scene, axis, factor)};
    plan.candidates = {fitted_.choice};
    plan.levels = fitted_.levels;
    plan.enough = fitted_.enough;
    const Plan read = read_plan(write_fit_plan(plan, fitted_.simplifiers), registry_);
    require_available(read, registry_);
    RunOptions options;
    options.folder = plan.folder / "run";
    options.stop_flag = stop_flag();
    Progress quiet(true);
    run_plan(read, registry_, options, quiet);
    SceneRequirement require;
    require.measure = result_.measure;
    require.at_most = result_.at_most;
    const fs::path records = options.folder / "records.jsonl";
    const FitPoint point =
        read_fit_points(fs::exists(records) ? read_records(records) : std::vector<json>(), plan, require)
            .front();
    if (!point.failure.empty()) {
      // A case that ends with the outcome "error", whose reference cannot be solved foremost, has no error.
      const std::string outcome = point.failure.substr(0, point.failure.find(':'));
      probe.ending = outcome == kPassesTolerance ? kNotMeasured : outcome;
      probe.message = point.failure;
      return;
    }
    probe.rest_error = point.error.front();
    probe.reference_error = point.own_error.front();
  }

  const volatile std::sig_atomic_t* stop_flag() const { return deadline_.flag(); }

  TrialSettings next_trial() {
    TrialSettings settings;
    settings.mesh = fitted_.folder / "organ.mesh";
    settings.folder = next_folder();
    settings.stop_flag = stop_flag();
    return settings;
  }

  fs::path next_folder() { return work_ / std::to_string(trials_++); }

  const EnvelopeOptions& options_;
  const Registry& registry_;
  Progress& progress_;
  Deadline deadline_;
  Stopwatch watch_;
  FittedFolder fitted_;
  fs::path work_;
  json fixed_;  ///< the fitted scene with its step in seconds
  json probes_m_;
  bool is_moving_ = false;
  std::size_t trials_ = 0;
  EnvelopeResult result_;
};

}  // namespace

EnvelopeResult run_envelope(const EnvelopeOptions& options, const Registry& registry, Progress& progress) {
  return Envelope(options, registry, progress).run();
}

}  // namespace palpate::experiments

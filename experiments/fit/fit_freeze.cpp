#include "experiments/fit/fit_freeze.h"

#include <algorithm>
#include <array>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/stopwatch.h"
#include "core/mesh/io/medit.h"
#include "core/mesh/topology.h"
#include "experiments/files/output_file.h"
#include "experiments/processes/deadline.h"
#include "experiments/records/record_file.h"
#include "experiments/records/run_folder.h"
#include "experiments/trials/motion_trial.h"
#include "reference/door/deform_problem.h"

namespace palpate::experiments {
namespace fs = std::filesystem;
namespace {

using nlohmann::json;

constexpr std::array kFreezeShares{0.5, 0.2};
constexpr int kFreezeTimings = 3;

class Freezer {
 public:
  Freezer(const FreezeTask& task, const Registry& registry, FitPoint& choice)
      : task_(task),
        registry_(registry),
        choice_(choice),
        deadline_(task.time_limit_s, task.stop_flag),
        mesh_file_(task.check.folder / "run" / "problems" / choice.mesh / "in.mesh"),
        mesh_(read_medit(mesh_file_, ReadOrientation::kKeep).mesh) {
    const fs::path answer = RunPaths{task.check.folder / "run"}.displacement(choice.case_id);
    rest_ = reference::read_displacement(answer, mesh_.points.size(), build_edges(mesh_).size());
    rest_.resize(mesh_.points.size());
  }

  std::vector<FrozenTry> run() {
    std::vector<FrozenTry> tries;
    for (const double share : kFreezeShares) {
      if (left_s() <= 0.0) break;
      tries.push_back(look_at(share, task_.folder / std::to_string(tries.size())));
      if (tries.back().why_not.empty()) break;
    }
    return tries;
  }

 private:
  double left_s() const { return task_.time_limit_s - watch_.seconds(); }

  FrozenTry look_at(double share, const fs::path& folder) {
    FrozenTry tried;
    tried.share = share;
    const std::vector<Index> still = find_still(rest_, share * task_.at_most * rms_displacement(rest_));
    tried.vertices = still.size();
    tried.tets = count_still_tets(mesh_, still);
    if (static_cast<double>(tried.tets) < kLeastFrozen * static_cast<double>(mesh_.tets.size())) {
      tried.why_not = why_not_frozen(tried, mesh_.tets.size(), task_.at_most);
      return tried;
    }
    create_folder(folder);
    const fs::path file = fs::absolute(folder / "frozen.json").lexically_normal();
    write_file_atomically(file, describe_frozen(still, mesh_.points.size(), std::nullopt).dump() + "\n");
    FitPoint held = look_at_rest(file, folder, tried);
    if (!held.failure.empty()) {
      tried.why_not = held.failure;
      return tried;
    }
    held.confirmed_on = choice_.confirmed_on;
    held.looked_at = choice_.looked_at;
    tried.error = held.known_error() + choice_.stepping->error.value_or(0.0);
    const std::vector<double> costs = look_at_motion(file, folder, tried);
    tried.why_not = why_not_frozen(tried, mesh_.tets.size(), task_.at_most);
    if (!tried.why_not.empty()) return tried;
    held.candidate.model.set["frozen"] = "frozen.json";
    held.steppings = choice_.steppings;
    held.stepping = choice_.stepping;
    held.stepping->error = choice_.stepping->error.value_or(0.0) + *tried.motion_error;
    held.stepping->cost_s = costs;
    held.stepping->is_auto = false;  // the held body's own bound is longer than what was verified
    choice_ = std::move(held);
    write_file_atomically(task_.folder / "frozen.json",
                          describe_frozen(still, mesh_.points.size(), tried.most_force_n).dump() + "\n");
    return tried;
  }

  /// The case of the contest, on the scene and on the other loads.
  FitPoint look_at_rest(const fs::path& file, const fs::path& folder, FrozenTry& tried) {
    FitPlan plan = task_.check;
    plan.folder = folder / "rest";
    plan.candidates = {choice_.candidate};
    plan.candidates.front().model.set["frozen"] = file.string();
    task_.run(plan, left_s());
    SceneRequirement require;
    require.measure = task_.measure;
    require.at_most = task_.at_most;
    const fs::path records = plan.folder / "run" / "records.jsonl";
    const std::vector<json> all = fs::exists(records) ? read_records(records) : std::vector<json>();
    for (const json& record : all) {
      const json force = record.value("/report/frozen_force_most_n"_json_pointer, json());
      if (force.is_number()) tried.most_force_n = std::max(tried.most_force_n, force.get<double>());
    }
    return read_fit_points(all, plan, require).front();
  }

  /// Both motions in turn; returns the costs of the held one.
  std::vector<double> look_at_motion(const fs::path& file, const fs::path& folder, FrozenTry& tried) {
    json held_scene = task_.scene;
    held_scene["model"]["frozen"] = file.string();
    std::vector<double> whole_s;
    std::vector<double> held_s;
    for (int k = 0; k < kFreezeTimings; ++k) {
      const MotionTrial whole = run_trial(task_.scene, folder / ("whole_" + std::to_string(k)));
      const MotionTrial held = run_trial(held_scene, folder / ("held_" + std::to_string(k)));
      if (whole.outcome != "completed" || held.outcome != "completed") {
        tried.motion_error.reset();
        return {};
      }
      whole_s.push_back(whole.second_s());
      held_s.push_back(held.second_s());
      tried.motion_error = history_difference(held.history, whole.history);
      tried.most_force_n = std::max(tried.most_force_n, held.frozen_force_n);
    }
    tried.cost_before_s = median(whole_s);
    tried.cost_s = median(held_s);
    return held_s;
  }

  MotionTrial run_trial(const json& scene, const fs::path& folder) const {
    TrialSettings settings;
    settings.mesh = mesh_file_;
    settings.folder = folder;
    settings.timeout_s = std::max(left_s(), 1.0);
    settings.stop_flag = deadline_.flag();
    return run_motion_trial(with_fixed_step(scene, choice_.stepping->step_s, task_.probes_m), settings,
                            registry_);
  }

  const FreezeTask& task_;
  const Registry& registry_;
  FitPoint& choice_;
  Deadline deadline_;
  Stopwatch watch_;
  fs::path mesh_file_;
  TetMesh mesh_;
  std::vector<Vec3> rest_;  ///< of the choice, at rest
};

}  // namespace

std::vector<FrozenTry> freeze_still_part(const FreezeTask& task, const Registry& registry, FitPoint& choice) {
  return Freezer(task, registry, choice).run();
}

}  // namespace palpate::experiments

#include "experiments/fit/fit_search.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/base/stopwatch.h"
#include "core/mesh/geometry.h"
#include "core/mesh/topology.h"
#include "core/simplify/sizing/size_file.h"
#include "experiments/contestants/stop.h"
#include "experiments/files/output_file.h"
#include "experiments/files/scratch_folder.h"
#include "experiments/grading/graded_mesh.h"
#include "experiments/grading/graded_sizes.h"
#include "experiments/plan_reader/plan.h"
#include "experiments/processes/deadline.h"
#include "experiments/scene_reader/scene_problem.h"
#include "experiments/scene_writer/placed_text.h"
#include "experiments/trials/modal_stepping.h"
#include "reference/door/moving_body.h"

namespace palpate::experiments {
namespace fs = std::filesystem;
namespace {

using nlohmann::json;

/// A third level of the reference has 64 times the mesh's tets, quadratic: up to here some minutes and 3 GB.
constexpr std::size_t kMostTetsForThirdLevel = 12'000;
/// Of the tolerance: a reference that is so good needs no further level.
constexpr double kEnoughShare = 0.1;

class Planner {
 public:
  Planner(const SearchTask& task, const Registry& registry, FitCandidates& candidates)
      : task_(task), registry_(registry), candidates_(candidates) {}

  FitSearch run(Progress& progress) {
    FitPlan& plan = found_.plan;
    plan.folder = task_.out / "search";
    plan.work = task_.work;
    plan.measures_answers = task_.is_stepped;
    plan.scenes.push_back(static_scene(task_.scene));
    drop_modes();
    drop_unable_steppings();
    const SceneRequirement& require = *task_.scene.require;
    plan.candidates = list_candidates(candidates_, task_.work, require, found_.dropped);
    if (plan.candidates.empty()) refuse("no candidate can do all of it");
    progress.show_long("mesh");
    const TetMesh mesh = build_scene_mesh(task_.scene.mesh).mesh;
    find_error_points(*place_scene(task_.scene, mesh).require, mesh);  // refuses places without a vertex
    for (std::size_t k = 1; k <= kOtherLoads + kFurtherLoads; ++k)
      found_.others.push_back(other_scene(k, mesh));
    drop_straying(mesh);
    const BoundingBox box = bounding_box(mesh.points);
    set_skin_bounds(candidates_, length(box.high - box.low));
    grade(mesh);
    plan.levels = mesh.tets.size() <= kMostTetsForThirdLevel ? 3 : 2;
    plan.enough = kEnoughShare * require.at_most;
    return std::move(found_);
  }

 private:
  /// Leaves out models of modes that the scene's motion is none for; what the scene needs beside is looked at
  /// with all others.
  void drop_modes() {
    const auto cannot = [&](const FitModel& model) {
      if (model.method != reference::kModalModel) return false;
      std::string why = model.cannot(task_.work, task_.scene.require->needs);
      if (!why.empty()) return false;  // is said of it as of all others
      why = why_no_modes(task_.scene, candidates_.steppings, model.set, registry_);
      if (!why.empty())
        found_.dropped.push_back(model.label + " (" + model.method + ") are not tried: " + why);
      return !why.empty();
    };
    auto& models = candidates_.models;
    models.erase(std::remove_if(models.begin(), models.end(), cannot), models.end());
  }

  /// Leaves out integrators that what may change would cost a new set-up.
  void drop_unable_steppings() {
    if (!task_.is_stepped) return;
    drop_steppings(candidates_.steppings, task_.scene.require->needs, found_.dropped);
    const auto& left = candidates_.steppings;
    if (std::all_of(left.begin(), left.end(), [](const FitStepping& one) { return one.modes.has_value(); }))
      refuse("no stepping can do all of it");
  }

  /// Leaves out skins that stray where few vertices lie on the skin: there is little to be won, and what is
  /// looked at in vain takes the time of what is confirmed.
  void drop_straying(const TetMesh& mesh) {
    constexpr double kFineShare = 0.5;
    const std::vector<std::uint8_t> is_skin = build_boundary_vertex_flags(mesh);
    const auto count = static_cast<double>(std::count(is_skin.begin(), is_skin.end(), 1));
    const double share = count / static_cast<double>(is_skin.size());
    if (share >= kFineShare) return;
    const auto strays = [&](const FitSimplifier& one) {
      if (one.skin_within)
        found_.dropped.push_back(one.label + " (" + one.method + ") is not tried: the skin is coarse, " +
                                 short_number(std::round(100.0 * share)) + "% of the vertices");
      return one.skin_within.has_value();
    };
    auto& known = candidates_.simplifiers;
    known.erase(std::remove_if(known.begin(), known.end(), strays), known.end());
  }

  [[noreturn]] void refuse(const std::string& why) const {
    std::string text = task_.scene.file.string() + ": require: " + why;
    for (const std::string& line : found_.dropped) text += "\n  " + line;
    throw InputError(text);
  }

  json other_scene(std::size_t k, const TetMesh& mesh) const {
    const json& own = found_.plan.scenes.front();
    const LoadRange range = k <= kOtherLoads ? LoadRange::kBorder : LoadRange::kWhole;
    json other = perturbed_scene(own, k, range);
    const fs::path file = task_.out / "loads" / ("scene_" + std::to_string(k) + ".yaml");
    create_folder(file.parent_path());
    write_file_atomically(file, other.dump(1) + "\n");
    try {
      resolve_problem(place_scene(read_scene(file), mesh), mesh);
    } catch (const InputError&) {
      other = perturbed_scene(own, k, range, false);
      write_file_atomically(file, other.dump(1) + "\n");
    }
    return other;
  }

  /// Prepares the sizes of graded meshes, and leaves out candidates on those that there are none of.
  void grade(const TetMesh& mesh) {
    const double left_s = task_.grading_s - watch_.seconds();
    if (!grade_simplifiers(candidates_, task_.scene, mesh,
                           {registry_, task_.out / "sizes", left_s, task_.stop_flag}, found_.dropped))
      found_.is_complete = false;
    auto& candidates = found_.plan.candidates;
    candidates.erase(
        std::remove_if(candidates.begin(), candidates.end(),
                       [&](const FitCandidate& candidate) { return !is_known(candidate.simplifier); }),
        candidates.end());
  }

  bool is_known(const std::string& simplifier) const {
    const auto& known = candidates_.simplifiers;
    return simplifier == kNoSimplifier ||
           std::any_of(known.begin(), known.end(),
                       [&](const FitSimplifier& one) { return one.label == simplifier; });
  }

  const SearchTask& task_;
  const Registry& registry_;
  FitCandidates& candidates_;
  Stopwatch watch_;
  FitSearch found_;
};

}  // namespace

FitSearch plan_search(const SearchTask& task, const Registry& registry, Progress& progress,
                      FitCandidates& candidates) {
  return Planner(task, registry, candidates).run(progress);
}

BoundaryProblem problem_at_rest(const Scene& scene, const TetMesh& mesh) {
  if (!scene.is_dynamic) return build_problem(place_scene(scene, mesh), mesh);
  const ScratchFolder scratch;
  const fs::path file = scratch.file("at_rest.yaml");
  write_file_atomically(file, lines_of_scene(static_scene(scene)));
  return build_problem(place_scene(read_scene(file), mesh), mesh);
}

bool grade_simplifiers(FitCandidates& candidates, const Scene& scene, const TetMesh& mesh,
                       const GradingTask& task, std::vector<std::string>& dropped) {
  const Deadline deadline(task.seconds, task.stop_flag);
  bool is_complete = true;
  /// Why there is nothing more to be looked for; empty as long as there is.
  const auto why_over = [&]() -> std::string {
    if (task.stop_flag != nullptr && *task.stop_flag != 0) return "it was interrupted";
    if (task.seconds <= 0.0 || *deadline.flag() != 0)
      return "the " + duration_text(std::max(task.seconds, 0.0)) + " that there were for it are over";
    return "";
  };
  const auto why_not = [&](FitSimplifier& simplifier) -> std::string {
    create_folder(task.folder);
    const BoundaryProblem problem = problem_at_rest(scene, mesh);
    const std::uint64_t tets =
        tets_after({StopKind::kRatio, simplifier.ratios.front(), ""}, mesh.tets.size());
    const GradedSizes graded =
        find_graded_sizes(*simplifier.grade, {mesh, problem, scene.dynamic.probes_m}, tets,
                          {task.registry, task.folder / "pilot", 1, deadline.flag()});
    if (!graded.failure.empty()) return graded.failure;
    const fs::path sizes = fs::absolute(task.folder / (simplifier.label + ".csv"));
    simplify::write_sizes(sizes, graded.sizes);
    simplifier.set["sizes"] = sizes.string();
    return "";
  };
  std::vector<FitSimplifier> kept;
  for (FitSimplifier& simplifier : candidates.simplifiers) {
    std::string why;
    if (simplifier.grade) {
      std::string over = why_over();
      try {
        why = over.empty() ? why_not(simplifier) : over;
      } catch (const InputError& error) {  // the scene has nothing of what the mesh is to be fine at
        why = error.what();
      }
      if (!why.empty() && over.empty()) over = why_over();
      if (!over.empty()) {
        why = "its sizes were not found: " + over;
        is_complete = false;
      }
    }
    if (why.empty()) {
      kept.push_back(std::move(simplifier));
    } else {
      dropped.push_back(simplifier.label + " (graded " + simplifier.method + "): " + why);
    }
  }
  candidates.simplifiers = std::move(kept);
  return is_complete;
}

}  // namespace palpate::experiments

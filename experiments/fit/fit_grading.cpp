#include "experiments/fit/fit_grading.h"

#include <algorithm>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/simplify/sizing/size_file.h"
#include "experiments/contestants/stop.h"
#include "experiments/files/output_file.h"
#include "experiments/files/scratch_folder.h"
#include "experiments/fit/fit_plan.h"
#include "experiments/grading/graded_mesh.h"
#include "experiments/grading/graded_sizes.h"
#include "experiments/processes/deadline.h"
#include "experiments/scene_reader/scene_problem.h"
#include "experiments/scene_writer/placed_text.h"
#include "experiments/text/terminal.h"

namespace palpate::experiments {
namespace fs = std::filesystem;

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

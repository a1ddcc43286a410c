#include "experiments/fit/fit_grading.h"

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/simplify/sizing/size_file.h"
#include "experiments/contestants/stop.h"
#include "experiments/files/output_file.h"
#include "experiments/files/scratch_folder.h"
#include "experiments/fit/fit_plan.h"
#include "experiments/grading/graded_mesh.h"
#include "experiments/grading/graded_sizes.h"
#include "experiments/scene_reader/scene_problem.h"
#include "experiments/scene_writer/placed_text.h"

namespace palpate::experiments {
namespace fs = std::filesystem;

BoundaryProblem problem_at_rest(const Scene& scene, const TetMesh& mesh) {
  if (!scene.is_dynamic) return build_problem(place_scene(scene, mesh), mesh);
  const ScratchFolder scratch;
  const fs::path file = scratch.file("at_rest.yaml");
  write_file_atomically(file, lines_of_scene(static_scene(scene)));
  return build_problem(place_scene(read_scene(file), mesh), mesh);
}

void grade_simplifiers(FitCandidates& candidates, const Scene& scene, const TetMesh& mesh,
                       const Registry& registry, const fs::path& folder,
                       const volatile std::sig_atomic_t* stop_flag, std::vector<std::string>& dropped) {
  const auto why_not = [&](FitSimplifier& simplifier) -> std::string {
    create_folder(folder);
    const BoundaryProblem problem = problem_at_rest(scene, mesh);
    const std::uint64_t tets =
        tets_after({StopKind::kRatio, simplifier.ratios.front(), ""}, mesh.tets.size());
    const GradedSizes graded = find_graded_sizes(*simplifier.grade, {mesh, problem, scene.dynamic.probes_m},
                                                 tets, {registry, folder / "pilot", 1, stop_flag});
    if (!graded.failure.empty()) return graded.failure;
    const fs::path sizes = fs::absolute(folder / (simplifier.label + ".csv"));
    simplify::write_sizes(sizes, graded.sizes);
    simplifier.set["sizes"] = sizes.string();
    return "";
  };
  std::vector<FitSimplifier> kept;
  for (FitSimplifier& simplifier : candidates.simplifiers) {
    std::string why;
    if (simplifier.grade) {
      try {
        why = why_not(simplifier);
      } catch (const InputError& error) {  // the scene has nothing of what the mesh is to be fine at
        why = error.what();
      }
    }
    if (why.empty()) {
      kept.push_back(std::move(simplifier));
    } else {
      dropped.push_back(simplifier.label + " (graded " + simplifier.method + "): " + why);
    }
  }
  candidates.simplifiers = std::move(kept);
}

}  // namespace palpate::experiments

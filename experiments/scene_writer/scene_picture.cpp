#include "experiments/scene_writer/scene_picture.h"

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/mesh/io/medit.h"
#include "experiments/files/scratch_folder.h"
#include "experiments/processes/report_script.h"
#include "reference/door/deform_problem.h"

namespace palpate::experiments {

std::vector<std::filesystem::path> pictures_of(const std::filesystem::path& scene) {
  const std::filesystem::path folder = std::filesystem::absolute(scene).parent_path();
  const std::string stem = scene.stem().string();
  return {folder / (stem + ".png"), folder / (stem + ".svg")};
}

std::vector<std::filesystem::path> draw_scene(const std::filesystem::path& scene, const TetMesh& mesh,
                                              const BoundaryProblem& problem) {
  const ScratchFolder scratch;
  write_medit(scratch.file("body.mesh"), mesh);
  write_file_atomically(scratch.file("problem.json"), reference::problem_to_json(problem).dump() + "\n");
  const std::filesystem::path folder = std::filesystem::absolute(scene).parent_path();
  const std::string stem = scene.stem().string();
  const ScriptAnswer answer =
      run_script(report_script("show_scene.py", {scratch.path().string(), folder.string(), stem}), scratch,
                 "the picture");
  if (answer.exit_code != 0) throw UnavailableError("interrupted before there was a picture");
  return pictures_of(scene);
}

}  // namespace palpate::experiments

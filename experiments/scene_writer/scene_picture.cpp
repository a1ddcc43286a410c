#include "experiments/scene_writer/scene_picture.h"

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/mesh/io/medit.h"
#include "experiments/files/file_bytes.h"
#include "experiments/files/places.h"
#include "experiments/files/scratch_folder.h"
#include "experiments/processes/process.h"
#include "experiments/processes/stop_signals.h"
#include "reference/door/deform_problem.h"

namespace palpate::experiments {

std::vector<std::filesystem::path> draw_scene(const std::filesystem::path& scene, const TetMesh& mesh,
                                              const BoundaryProblem& problem) {
  const std::filesystem::path script = std::filesystem::path(source_folder()) / "report" / "show_scene.py";
  if (!std::filesystem::exists(script))
    throw UnavailableError("the picture's script is missing: " + script.string());
  const ScratchFolder scratch;
  write_medit(scratch.file("body.mesh"), mesh);
  write_file_atomically(scratch.file("problem.json"), reference::problem_to_json(problem).dump() + "\n");
  const std::filesystem::path folder = std::filesystem::absolute(scene).parent_path();
  const std::string stem = scene.stem().string();
  ProcessSpec spec;
  spec.arguments = {"/usr/bin/python3", "-B", script.string(), scratch.path().string(),
                    folder.string(),    stem};
  spec.standard_error = scratch.file("errors.txt");
  spec.stop_flag = catch_stop_signals();
  const ProcessResult result = run_process(spec);
  if (result.end != ProcessEnd::kExited || result.exit_code != 0) {
    std::string last = read_bytes(spec.standard_error).value_or("");
    while (!last.empty() && last.back() == '\n') last.pop_back();
    throw UnavailableError("the picture could not be drawn (" + result.message +
                           "): " + last.substr(last.rfind('\n') + 1));
  }
  return {folder / (stem + ".png"), folder / (stem + ".svg")};
}

}  // namespace palpate::experiments

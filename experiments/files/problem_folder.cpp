#include "experiments/files/problem_folder.h"

#include "core/base/atomic_file.h"
#include "core/mesh/io/medit.h"
#include "experiments/files/output_file.h"

namespace palpate::experiments {

ProblemPaths write_problem_folder(const TetMesh& mesh, const nlohmann::json& problem,
                                  const std::filesystem::path& folder) {
  create_folder(folder);
  ProblemPaths paths{std::filesystem::absolute(folder / "in.mesh"),
                     std::filesystem::absolute(folder / "problem.json")};
  write_medit(paths.mesh, mesh);
  write_file_atomically(paths.problem, problem.dump() + "\n");
  return paths;
}

}  // namespace palpate::experiments

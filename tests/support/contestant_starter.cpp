#include "tests/support/contestant_starter.h"

#include <filesystem>
#include <fstream>

#include "core/mesh/io/medit.h"

namespace palpate::test {

experiments::ContestantAnswer ContestantStarter::run(const std::string& method, const TetMesh& mesh,
                                                     const nlohmann::json& problem,
                                                     const nlohmann::json& options) {
  const auto folder = scratch_ / std::to_string(++asked_);
  std::filesystem::create_directories(folder / "scratch");
  experiments::ContestantTask task;
  task.method = *registry_.find(method);
  task.mesh_in = folder / "in.mesh";
  task.problem_in = folder / "problem.json";
  write_medit(task.mesh_in, mesh);
  std::ofstream(task.problem_in) << problem.dump();
  task.scratch = folder / "scratch";
  task.options = options;
  task.timeout_s = 100.0;
  return run_contestant(task);
}

}  // namespace palpate::test

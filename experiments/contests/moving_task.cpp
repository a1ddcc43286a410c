#include "experiments/contests/moving_task.h"

#include "core/base/error.h"
#include "experiments/contests/problem_files.h"

namespace palpate::experiments {

ContestantTask start_task(const std::string& method, const nlohmann::json& problem, const TetMesh& mesh,
                          const Registry& registry, const std::filesystem::path& folder) {
  constexpr double kNoTimeout = 1e8;
  const auto entry = registry.find(method);
  if (!entry) throw UnavailableError(method + " is unavailable: there is no such method");
  const std::string why = entry->contestant->unavailable();
  if (!why.empty()) throw UnavailableError(method + " is unavailable: " + why);
  ProblemFiles files;
  files.mesh = mesh;
  write_problem(files, problem, folder);
  ContestantTask task;
  task.method = *entry;
  task.mesh_in = files.mesh_file;
  task.problem_in = files.problem_file;
  task.scratch = folder / "run";
  std::filesystem::create_directories(task.scratch);
  task.options = resolve_options(*entry->method, {});
  task.timeout_s = kNoTimeout;
  return task;
}

ContestantTask start_moving_task(const std::string& method, const reference::MovingBody& body,
                                 const TetMesh& mesh, const Registry& registry,
                                 const std::filesystem::path& folder) {
  return start_task(method, reference::moving_body_to_json(body), mesh, registry, folder);
}

ContestantTask start_replay(const reference::MovingBody& body, const TetMesh& mesh, const Registry& registry,
                            const std::filesystem::path& folder) {
  if (body.model.method != reference::kModalModel)
    return start_moving_task("engine.replay", body, mesh, registry, folder);
  ContestantTask task = start_moving_task("reduced.modal_replay", body, mesh, registry, folder);
  for (const char* key : {"elements", "modes", "correction", "factor"})
    task.options[key] = body.model.options.at(key);
  task.options["time_step_s"] = *body.stepping.time_step_s;
  return task;
}

ContestantAnswer run_moving_task(const ContestantTask& task, const std::string& where) {
  ContestantAnswer answer = run_contestant(task);
  if (answer.outcome == "bad_input") throw InputError(where + ": " + answer.message);
  if (answer.outcome != "ok" && answer.outcome != "interrupted")
    throw UnavailableError(task.method.method->name + ": " + answer.outcome + ": " + answer.message);
  return answer;
}

}  // namespace palpate::experiments

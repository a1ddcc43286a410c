#include "experiments/contests/problem_files.h"

#include "core/base/error.h"
#include "experiments/files/file_hash.h"
#include "experiments/files/problem_folder.h"
#include "experiments/records/case_record.h"
#include "reference/door/deform_problem.h"

namespace palpate::experiments {
namespace fs = std::filesystem;

using nlohmann::json;

json problem_sweep(const json& sweep) {
  json own = json::object();
  for (const char* name : {"poisson_ratio", "vertices"}) {
    if (sweep.contains(name)) own[name] = sweep.at(name);
  }
  return own;
}

std::string problem_id(const std::string& scene, const json& sweep) {
  std::string id = scene;
  const json own = problem_sweep(sweep);
  for (const auto& [name, value] : own.items()) id += "/" + name + "=" + value.dump();
  return id;
}

void write_problem(ProblemFiles& files, const json& problem, const fs::path& folder) {
  const ProblemPaths paths = write_problem_folder(files.mesh, problem, folder);
  files.mesh_file = paths.mesh;
  files.problem_file = paths.problem;
  files.mesh_hash = hash_file(files.mesh_file);
  files.problem_hash = hash_file(files.problem_file);
}

void write_problem(ProblemFiles& files, const fs::path& folder) {
  write_problem(files, reference::problem_to_json(files.problem), folder);
}

json start_reference_record(const Plan& plan, const json& subject, const std::string& scene,
                            const json& sweep, const std::string& outcome, const std::string& failure) {
  std::string id = scene + "/reference";
  for (const auto& [name, value] : sweep.items()) id += "/" + name + "=" + value.dump();
  json record = start_input_record(plan, subject, id, "reference");
  record["sweep"] = sweep;
  record["outcome"] = outcome;
  record["message"] = failure;
  return record;
}

void describe_problem(const RunPaths& paths, const std::string& id, const ProblemFiles& files,
                      json& described) {
  const json now = {{"mesh_hash", files.mesh_hash},
                    {"problem_hash", files.problem_hash},
                    {"vertices", files.mesh.points.size()},
                    {"tets", files.mesh.tets.size()}};
  if (described.contains(id) && described.at(id) != now) {
    throw InputError(paths.folder.string() + ": this run cannot be continued; the problem " + id +
                     " is no longer what it was");
  }
  described[id] = now;
}

}  // namespace palpate::experiments

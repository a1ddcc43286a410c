// Scenes as problems on their meshes, and both as files that requests name.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "core/mesh/boundary_problem.h"
#include "core/mesh/tet_mesh.h"
#include "experiments/records/run_folder.h"

namespace palpate::experiments {

/// A mesh in metres with its problem, as files that requests name.
struct ProblemFiles {
  TetMesh mesh;
  BoundaryProblem problem;
  std::filesystem::path mesh_file;
  std::filesystem::path problem_file;
  std::string mesh_hash;
  std::string problem_hash;
};

/// The part of a case's sweep that makes its problem: poisson_ratio and vertices.
nlohmann::json problem_sweep(const nlohmann::json& sweep);

/// "kidney_gravity/poisson_ratio=0.45".
std::string problem_id(const std::string& scene, const nlohmann::json& sweep);

/// Writes mesh and problem below `folder`, which is made, and fills in the files and their hashes.
/// Throws: InputError if the folder cannot be written.
void write_problem(ProblemFiles& files, const std::filesystem::path& folder);

/// Writes a mesh with any problem, as the JSON that the door takes. Throws: InputError if the folder cannot
/// be written.
void write_problem(ProblemFiles& files, const nlohmann::json& problem, const std::filesystem::path& folder);

/// The record of a reference on a scene with what the sweep changes of it, to be filled: the case is
/// "kidney_gravity/reference/poisson_ratio=0.45", the outcome as given, `failure` its message.
nlohmann::json start_reference_record(const Plan& plan, const nlohmann::json& subject,
                                      const std::string& scene, const nlohmann::json& sweep,
                                      const std::string& outcome, const std::string& failure);

/// Names the problem in `described`, the provenance's key "problems", or holds it against what an earlier
/// start named there. Throws: InputError if it is no longer the same.
void describe_problem(const RunPaths& paths, const std::string& id, const ProblemFiles& files,
                      nlohmann::json& described);

}  // namespace palpate::experiments

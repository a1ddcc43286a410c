// A mesh and a problem on it as the two files that requests name.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/mesh/tet_mesh.h"

namespace palpate::experiments {

struct ProblemPaths {
  std::filesystem::path mesh;     ///< in.mesh
  std::filesystem::path problem;  ///< problem.json
};

/// Writes both below `folder`, which is made. Returns: their absolute paths.
/// Throws: InputError if the folder cannot be written.
ProblemPaths write_problem_folder(const TetMesh& mesh, const nlohmann::json& problem,
                                  const std::filesystem::path& folder);

}  // namespace palpate::experiments

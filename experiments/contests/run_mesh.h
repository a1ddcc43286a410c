// The meshes of a run: made or read once, kept as files, the same on every start.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/mesh/tet_mesh.h"
#include "experiments/plan_reader/plan.h"

namespace palpate::experiments {

/// An input mesh of a run.
struct RunMesh {
  std::string name;
  std::filesystem::path file;  ///< in the run folder
  std::string hash;            ///< of that file
  TetMesh mesh;
  double ideal_volume = 0.0;  ///< mean volume of its tets
  std::vector<std::string> notes;
  nlohmann::json source;  ///< how it came about, for provenance
};

/// Makes or reads the mesh and writes it to `file`.
/// Throws: InputError or UnavailableError as make_shape and read_mesh do.
RunMesh obtain_mesh(const PlanMesh& plan_mesh, const std::filesystem::path& file);

/// Reads the mesh that an earlier start wrote. Throws: InputError if its bytes are not those that
/// `provenance` names.
RunMesh reload_mesh(const PlanMesh& plan_mesh, const std::filesystem::path& file,
                    const nlohmann::json& provenance);

/// Name, source, sizes and hash, for provenance.
nlohmann::json describe_mesh(const RunMesh& mesh);

}  // namespace palpate::experiments

// The meshes of a run: made or read once, kept as files, the same on every start.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/mesh/tet_mesh.h"
#include "experiments/contests/contest.h"
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
/// Throws: InputError or UnavailableError as make_shape and read_mesh do; InputError for a file whose mesh is
/// not valid. What is wrong with a file is said with the line of the plan.
RunMesh obtain_mesh(const PlanMesh& plan_mesh, const std::filesystem::path& file);

/// Reads the mesh that an earlier start wrote. Throws: InputError if its bytes are not those that
/// `provenance` names.
RunMesh reload_mesh(const PlanMesh& plan_mesh, const std::filesystem::path& file,
                    const nlohmann::json& provenance);

/// Name, source, sizes and hash, for provenance.
nlohmann::json describe_mesh(const RunMesh& mesh);

/// Fills `meshes` with the plan's, in its order, and says their notes: makes or reads them, or reads those
/// that an earlier start wrote, where `earlier`, its provenance, is not null.
/// Returns: what the provenance is to name of them; nothing new where `earlier` names them.
/// Throws:  as obtain_mesh; InputError if a mesh is no longer what `earlier` names; RunInterrupted
///          between two meshes, if the run is to stop.
nlohmann::json prepare_meshes(const ContestSetting& setting, const nlohmann::json& earlier,
                              std::vector<RunMesh>& meshes);

}  // namespace palpate::experiments

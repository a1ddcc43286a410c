// The fill behind the collapse: the project's gmsh tool, started as a process.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/mesh/tet_mesh.h"
#include "reference/simplifier_support/isolated_run.h"

namespace palpate::reference {

/// Fills a closed surface by palpate_gmsh (method gmsh.delaunay, with its options: interior_size,
/// optimize_threshold), which stands beside this program. The time is the tool's own kernel time: the files
/// between the two are not in it. `folder` is for these files. Throws: std::runtime_error with the tool's
/// message.
TimedMesh fill_by_gmsh(const SurfaceMesh& surface, const nlohmann::json& options,
                       const std::filesystem::path& folder);

}  // namespace palpate::reference

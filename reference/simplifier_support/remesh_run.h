// The run that all remeshers share: read the mesh, meet the count by searching for the edge length, report.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "core/mesh/tet_mesh.h"
#include "reference/door/adapter.h"
#include "reference/simplifier_support/isolated_run.h"

namespace palpate::reference {

/// A remesher as run_remesher needs it.
struct Remesher {
  /// The timed kernel: a new mesh of about `target` tets with edges of about `size`. Throws
  /// std::runtime_error where the vendor fails.
  std::function<TimedMesh(const TetMesh& mesh, std::uint64_t target, double size)> remesh;
  std::string size_name;  ///< name of the size among the tuned parameters: "edge_length"
  double first_factor =
      1.0;  ///< first size over the edge of a regular tet of the mean volume that the target leaves
  double time_limit_per_tet_s = 0.02;  ///< a try is stopped after a minute and this time for each tet
};

/// Reads "stop": the number of tets to aim at.
///
///   {"tets": N} gives N, {"ratio": R} gives tets_in - ceil(R tets_in), at least 1, at most tets_in
///
/// Throws: InputError for "fusions", "limit", several stops or a value that fits none.
std::uint64_t read_tet_target(const nlohmann::json& stop, std::uint64_t tets_in);

/// Answers a request with a remesher that takes a size.
///
/// Without "tuned" in the request the size is searched for (reference/simplifier_support/size_search.h), each
/// try in a process of its own, and the nearest try is the answer; with it, the kernel runs once at that
/// size. Report: counts, "target_tets", "count_mismatch_relative" (tets_out / target_tets - 1), "tries";
/// notes say how the count was met.
Response run_remesher(const Request& request, const Remesher& remesher);

}  // namespace palpate::reference

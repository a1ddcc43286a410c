// How far a motion of the engine has come, and what limits its step, in a file for whoever waits for it.
#pragma once

#include <cstdint>
#include <filesystem>

#include "core/mesh/tet_mesh.h"
#include "reference/elastic_models/progress_file.h"
#include "reference/engine/motion_setup.h"

namespace palpate::reference {

/// The tetrahedron of least height at a vertex: its place, its height (three volumes over its largest face),
/// and the median of the mesh's.
struct FlatTet {
  Index tet = kNoIndex;
  double height_m = 0.0;
  double median_height_m = 0.0;
};

/// Requires: a vertex with at least one tet.
FlatTet find_flattest_tet(const TetMesh& mesh, Index vertex);

/// The file progress.json (palpate/progress/1):
///
///   {"schema": "palpate/progress/1", "time_step_s": 1e-4, "stable_step_s": 1.1e-4, "stable_by":
///   "eigenvalues",
///    "steps": 5000, "steps_done": 100, "seconds": 0.4,
///    "limiting": {"vertex": 7, "place_m": [x, y, z], "tet": 12, "height_m": 0.001, "median_height_m":
///    0.003}}
///
/// It is there before the first step, and written anew a few times a second at most. `limiting` is where the
/// motion that sets the bound has the most kinetic energy; null where there is no bound.
class MotionProgress {
 public:
  /// An empty path: no file.
  MotionProgress(const std::filesystem::path& file, const MotionSetup& setup, const TetMesh& mesh);

  /// So many steps are done.
  void reach(std::uint64_t steps_done) { file_.reach(steps_done); }

 private:
  ProgressFile file_;
};

}  // namespace palpate::reference

// Meshes of a fit that are graded by its scene.
#pragma once

#include <csignal>
#include <filesystem>
#include <string>
#include <vector>

#include "core/mesh/boundary_problem.h"
#include "core/mesh/tet_mesh.h"
#include "experiments/fit/fit_candidates.h"

namespace palpate::experiments {

/// The problem of a scene, at rest; a moving one with each load at its greatest share.
BoundaryProblem problem_at_rest(const Scene& scene, const TetMesh& mesh);

/// Where the sizes go, and how long they may be looked for.
struct GradingTask {
  const Registry& registry;
  std::filesystem::path folder;  ///< is made if there is anything to grade
  double seconds = 60.0;         ///< of the clock, for all of them
  const volatile std::sig_atomic_t* stop_flag = nullptr;
};

/// Finds the sizes of every graded simplifier on the scene's own loads and leaves them in the folder: on
/// other loads the candidate has the same mesh. One whose sizes cannot be found, or not in time, is taken
/// out, and `dropped` says why. Returns: false if time or user stopped it before all were found. Throws:
/// InputError if the folder cannot be written.
bool grade_simplifiers(FitCandidates& candidates, const Scene& scene, const TetMesh& mesh,
                       const GradingTask& task, std::vector<std::string>& dropped);

}  // namespace palpate::experiments

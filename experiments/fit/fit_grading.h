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

/// Finds the sizes of every graded simplifier on the scene's own loads and leaves them in `folder`: on other
/// loads the candidate has the same mesh. One whose sizes cannot be found is taken out, and `dropped` says
/// why. Throws: InputError if the folder cannot be written.
void grade_simplifiers(FitCandidates& candidates, const Scene& scene, const TetMesh& mesh,
                       const Registry& registry, const std::filesystem::path& folder,
                       const volatile std::sig_atomic_t* stop_flag, std::vector<std::string>& dropped);

}  // namespace palpate::experiments

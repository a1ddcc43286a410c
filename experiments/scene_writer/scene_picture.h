// A picture of a scene: where it is held and where it is pressed.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/mesh/boundary_problem.h"
#include "core/mesh/tet_mesh.h"

namespace palpate::experiments {

/// What draw_scene writes: STEM.png and STEM.svg beside the scene, STEM being its name without its ending.
std::vector<std::filesystem::path> pictures_of(const std::filesystem::path& scene);

/// Draws the scene's skin from above and from below by the report's Python (report/show_scene.py).
/// Returns both paths. Throws: UnavailableError if the script, Python or matplotlib is missing, or fails.
std::vector<std::filesystem::path> draw_scene(const std::filesystem::path& scene, const TetMesh& mesh,
                                              const BoundaryProblem& problem);

}  // namespace palpate::experiments

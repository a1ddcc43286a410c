// What a fit searches: candidates that can do what the scene needs, on the scene at rest, and the other loads
// that its choice is checked on.
#pragma once

#include <csignal>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/mesh/boundary_problem.h"
#include "core/mesh/tet_mesh.h"
#include "experiments/fit/candidates/fit_plan.h"
#include "experiments/text/terminal.h"

namespace palpate::experiments {

struct SearchTask {
  const std::filesystem::path& out;  ///< the fit's folder: "search", "sizes" and "loads" go below it
  const Scene& scene;
  FitWork work = FitWork::kFirst;
  double grading_s = 0.0;   ///< for graded meshes
  bool is_stepped = false;  ///< integrators are tried
  const volatile std::sig_atomic_t* stop_flag = nullptr;
};

struct FitSearch {
  FitPlan plan;                        ///< of one scene
  std::vector<nlohmann::json> others;  ///< the scene under the other loads, kOtherLoads + kFurtherLoads
  std::vector<std::string> dropped;    ///< what cannot do what is needed, and why
  bool is_complete = true;             ///< false: a graded mesh was not prepared
};

/// Takes out of `candidates` what cannot do what the scene needs, prepares graded meshes, and plans the rest.
/// Another load whose place would take hold of nothing on the scene's mesh keeps its place.
///
/// Throws: InputError where nothing can do all of it, for places of the error without a vertex, and for the
/// scene's mesh as build_scene_mesh.
FitSearch plan_search(const SearchTask& task, const Registry& registry, Progress& progress,
                      FitCandidates& candidates);

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

/// Loads beside the scene's own that the choice is made by (numbers 1, 2, ... of perturbed_scene, on the
/// border).
inline constexpr std::size_t kOtherLoads = 3;
/// Loads anywhere in the range that it is looked at coarsely under after that (the numbers that follow), and
/// so many of them, the worst, that it is confirmed on.
inline constexpr std::size_t kFurtherLoads = 12;
inline constexpr std::size_t kConfirmingLoads = 2;

}  // namespace palpate::experiments

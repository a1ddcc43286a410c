// The run of a training plan: fields to learn from, and the fits, which the program of the springs does.
#pragma once

#include <csignal>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>

#include "core/mesh/boundary_problem.h"
#include "core/mesh/tet_mesh.h"
#include "experiments/registry/registry.h"
#include "experiments/spring_training/training_plan.h"
#include "experiments/text/terminal.h"

namespace palpate::experiments {

/// What a training run needs beside its plan.
struct TrainingSetting {
  const Registry& registry;
  std::filesystem::path scratch;  ///< a folder of its own
  Progress& progress;
  int threads = 1;                                        ///< that the finite elements may use
  const volatile std::sig_atomic_t* stop_flag = nullptr;  ///< the run is given up when it turns non-zero
  std::function<void(const std::string&)> note{};         ///< gets what a person should know; may be empty
};

/// Where a run leaves its constants.
struct TrainingFiles {
  std::filesystem::path springs;  ///< as core/springs/network/springs_csv.h writes them
  std::filesystem::path moduli;   ///< as core/springs/network/moduli_csv.h does; only with a volume model
};

/// One clamp of the plan with one of its loads, by their places, on its mesh.
/// Throws: InputError as build_problem does, with the clamp's or load's line.
BoundaryProblem place_case(const TrainingPlan& plan, std::size_t clamp, std::size_t load,
                           const TetMesh& mesh);

/// Makes the mesh, places each case on it and solves it with quadratic and with linear elements (fem.p2,
/// fem.p1; what an earlier run solved is taken from the cache), has the constants fitted (contest training,
/// reference/springs/training_run.h) and returns the report of that.
/// Throws: InputError as build_problem does, with the case's clamp or load; UnavailableError if a program
/// cannot
///         run, or the elements do not converge; RunInterrupted; what was solved stays in the cache.
nlohmann::json run_training(const TrainingPlan& plan, const TrainingSetting& setting,
                            const TrainingFiles& files);

}  // namespace palpate::experiments

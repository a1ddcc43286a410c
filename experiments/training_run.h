// The run of a training plan: fields to learn from, one fit a ridge, and the errors of each set.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/mesh/spring_network.h"
#include "core/mesh/tet_mesh.h"
#include "core/springs/training.h"
#include "experiments/contestant.h"
#include "experiments/terminal.h"
#include "experiments/training_plan.h"

namespace palpate::experiments {

/// The cases of one split on the plan's mesh, with the fields that they should give.
struct TrainingCases {
  std::string name;
  springs::TrainingSet set;
};

/// Mesh, start and cases of a plan.
struct TrainingInput {
  TetMesh mesh;                       ///< in metres
  SpringNetwork network;              ///< at the start
  springs::RankOneTerms terms;        ///< the springs, then the dilatations
  std::vector<TrainingCases> splits;  ///< train, validate, test_loads, test_clamps
  std::vector<std::string> notes;
};

/// Makes the mesh, identifies the springs to start from, places each case on the mesh and solves it with
/// quadratic elements (fem.p2; what an earlier run solved is taken from the cache).
/// Throws: InputError as build_problem does, with the case's clamp or load; UnavailableError if fem.p2 cannot
///         run or does not converge.
TrainingInput build_training_input(const TrainingPlan& plan, const Registry& registry,
                                   const std::filesystem::path& scratch, int threads, Progress& progress);

/// Errors of one split before and after.
struct SplitErrors {
  std::string name;
  std::vector<std::string> cases;
  std::vector<double> before;  ///< relative L2, one a case
  std::vector<double> after;
};

struct RidgeResult {
  double ridge = 0.0;
  double train_rms = 0.0;
  double validate_rms = 0.0;
  springs::LbfgsReport lbfgs;
};

struct TrainingOutcome {
  std::vector<RidgeResult> ridges;
  std::size_t chosen = 0;  ///< the ridge of the least validation error
  std::vector<double> constant;
  std::vector<SplitErrors> errors;
};

/// Fits with each ridge; the validation set alone chooses, and the test sets are solved once, at the end.
TrainingOutcome run_training(const TrainingInput& input, const TrainingPlan& plan, Progress& progress);

/// sqrt of the mean of the squares.
double root_mean_square(const std::vector<double>& values);

}  // namespace palpate::experiments

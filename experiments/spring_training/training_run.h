// The run of a training plan: fields to learn from, one fit a ridge, and the errors of each set.
#pragma once

#include <csignal>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/mesh/spring_network.h"
#include "core/mesh/tet_mesh.h"
#include "core/springs/training/training.h"
#include "experiments/contestants/contestant.h"
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
};

/// Thrown when the stop flag rose. What was solved stays in the cache.
struct TrainingInterrupted : std::runtime_error {
  TrainingInterrupted() : std::runtime_error("training was interrupted") {}
};

/// Spring constants, and moduli where there is a volume model, as terms.
struct SpringStart {
  SpringNetwork network;
  springs::RankOneTerms terms;  ///< the springs, then the dilatations
};

/// The cases of one split on the plan's mesh, with the fields that they should give.
struct TrainingCases {
  std::string name;
  springs::TrainingSet set;
  std::vector<double> linear_elements;  ///< relative L2 error of fem.p1, one a case
};

/// Mesh, start and cases of a plan.
struct TrainingInput {
  TetMesh mesh;  ///< in metres
  SpringStart start;
  std::vector<TrainingCases> splits;  ///< train, validate, test_loads, test_clamps
  std::vector<std::string> notes;
};

/// One clamp of the plan with one of its loads, by their places, on its mesh.
/// Throws: InputError as build_problem does, with the clamp's or load's line.
BoundaryProblem place_case(const TrainingPlan& plan, std::size_t clamp, std::size_t load,
                           const TetMesh& mesh);

/// Springs by the plan's method with its volume model, all constants at what the material says.
/// `calibrated`: all springs times one factor, from the moduli that the network has on its own mesh.
SpringStart build_spring_start(const TetMesh& mesh, const TrainingPlan& plan, bool face_opposite,
                               bool calibrated, std::vector<std::string>& notes);

/// Makes the mesh, identifies the springs to start from, places each case on the mesh and solves it with
/// quadratic and with linear elements (fem.p2, fem.p1; what an earlier run solved is taken from the cache).
/// Throws: InputError as build_problem does, with the case's clamp or load; UnavailableError if the elements
///         cannot run or do not converge; TrainingInterrupted.
TrainingInput build_training_input(const TrainingPlan& plan, const TrainingSetting& setting);

/// Errors of one split: relative L2 over the volume.
struct SplitErrors {
  std::string name;
  std::vector<std::string> cases;
  std::vector<std::vector<double>> of_model;  ///< [model][case], models as TrainingOutcome names them
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
  double start_validate_rms = 0.0;
  bool start_is_kept = false;       ///< on the validation set no fit is better than the start
  std::vector<double> constant;     ///< of the chosen ridge, or of the start where that is kept
  std::vector<std::string> models;  ///< "start", "calibrated_opposite", "fem_p1", "trained"
  std::vector<SplitErrors> errors;
};

/// Fits with each ridge; the validation set alone chooses, among the start and the fits, and the test sets
/// are solved once, at the end. Beside the trained constants stand those to start from, the start method with
/// face-opposite springs calibrated on its own mesh, and linear elements.
TrainingOutcome run_training(const TrainingInput& input, const TrainingPlan& plan,
                             const TrainingSetting& setting);

/// sqrt of the mean of the squares.
double root_mean_square(const std::vector<double>& values);

}  // namespace palpate::experiments

// What a fit left, as the start of its envelope.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "experiments/fit/candidates/fit_candidates.h"
#include "experiments/fit/candidates/fit_plan.h"

namespace palpate::experiments {

/// A folder of `palpate fit` that has a choice.
struct FittedFolder {
  std::filesystem::path folder;
  nlohmann::json fit;         ///< palpate/fit/1
  nlohmann::json scene;       ///< as fitted: with organ.mesh and the model
  nlohmann::json rest_scene;  ///< as judged: on the mesh that was fitted, at rest
  FitCandidate choice;
  FitCandidates simplifiers;  ///< its simplifier alone
  int levels = 2;             ///< of the reference
  double enough = 0.0;        ///< no further level below that own error

  double at_most() const { return fit.at("at_most").get<double>(); }
  std::filesystem::path scene_file() const { return folder / "scene.yaml"; }
};

/// Throws: InputError for a folder that is no fit's, or a fit without a choice, or files of it that cannot be
/// read.
FittedFolder read_fitted_folder(const std::filesystem::path& folder);

}  // namespace palpate::experiments

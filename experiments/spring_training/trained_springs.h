// Springs that a plan trains before it runs: `train: FILE` of a contestant.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

#include "experiments/spring_training/training_run.h"

namespace palpate::experiments {

/// Files that a training plan gave, and its report (run_training).
struct TrainedSprings {
  std::filesystem::path springs;
  std::filesystem::path moduli;  ///< empty without a volume model
  nlohmann::json report;
};

/// Runs a training plan, or takes what an earlier run of the same plan, mesh and programs left in the cache.
/// Throws: as run_training; InputError if the cache cannot be written.
TrainedSprings train_cached(const std::filesystem::path& plan_file, const TrainingSetting& setting);

}  // namespace palpate::experiments

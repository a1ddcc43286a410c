// What a training run leaves: its constants as files, its errors as JSON and as tables.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "experiments/spring_training/training_run.h"

namespace palpate::experiments {

/// The trained springs, as core/springs/network/springs_csv.h writes them.
void write_trained_springs(const std::filesystem::path& path, const TrainingInput& input,
                           const TrainingOutcome& outcome);

/// The trained moduli of the vertices or tets, one row each: "vertex,modulus_pa" or "tet,modulus_pa".
/// Requires: a volume model.
void write_trained_moduli(const std::filesystem::path& path, TrainedVolume volume, const TrainingInput& input,
                          const TrainingOutcome& outcome);

/// Counts, the ridges with their errors, and for each set and model the root mean square and the worst of the
/// relative L2 errors, with every case.
nlohmann::json build_training_report(const TrainingInput& input, const TrainingOutcome& outcome);

/// The same for a person: a table of sets and models, one of ridges, the chosen one.
std::string training_tables(const TrainingOutcome& outcome);

}  // namespace palpate::experiments

// What a training run found, for a person.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace palpate::experiments {

/// The report of run_training as a table of sets and models, one of ridges, and the chosen one.
std::string training_tables(const nlohmann::json& report);

}  // namespace palpate::experiments

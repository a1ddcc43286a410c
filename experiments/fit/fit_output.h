// What a fit leaves: fit.json, a page of text, the mesh and a scene that is ready for `simulate`.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "experiments/fit/fit_run.h"

namespace palpate::experiments {

/// The fit as data (palpate/fit/1): choice, cost, error, what each saving is worth, everything that was tried
/// and why it was not taken.
nlohmann::json describe_fit(const FitResult& result);

/// The same for people, in Markdown.
std::string fit_text(const FitResult& result, const nlohmann::json& fit);

/// Writes fit.json and fit.md; where there is a choice, organ.mesh (metres) and scene.yaml with its model
/// too. Throws: InputError if they cannot be written.
void write_fit(const FitResult& result, const std::filesystem::path& folder);

}  // namespace palpate::experiments

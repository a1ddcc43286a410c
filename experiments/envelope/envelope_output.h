// What an envelope leaves beside its fit: envelope.json, a page of text, and the key in the scene.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "experiments/envelope/envelope_run.h"
#include "experiments/scene_reader/scene.h"

namespace palpate::experiments {

/// palpate/envelope/1.
nlohmann::json describe_envelope(const EnvelopeResult& result);

/// The same for people, in Markdown.
std::string envelope_text(const nlohmann::json& envelope);

/// Writes envelope.json and envelope.md into the fit's folder, and the key "envelope" into its scene. Throws:
/// InputError if they cannot be written.
void write_envelope(const nlohmann::json& envelope, const std::filesystem::path& folder);

/// What a scene has that its envelope does not cover, a line each; empty without an envelope, and where all
/// is within. A factor between the greatest that holds and the least that does not counts as beyond. Throws:
/// InputError for an envelope that cannot be read.
std::vector<std::string> leaves_envelope(const Scene& scene);

}  // namespace palpate::experiments

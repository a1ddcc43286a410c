// A scene on another mesh, as text: its regions in metres, so that they stay where the whole mesh had them.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "experiments/scene_reader/scene.h"

namespace palpate::experiments {

/// The scene's file with `mesh` as its mesh, a file in metres beside it, and the regions that it was placed
/// with. Throws: InputError as read_yaml.
nlohmann::json placed_scene(const Scene& scene, const Scene& placed, const std::string& mesh);

/// A mapping whose values stand on a line each; lists of mappings a line an entry. JSON, which YAML reads.
std::string lines_of_scene(const nlohmann::json& scene);

}  // namespace palpate::experiments

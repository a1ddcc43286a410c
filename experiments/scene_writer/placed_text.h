// A scene on another mesh, as text: its regions in metres, so that they stay where the whole mesh had them.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "experiments/scene_reader/scene.h"

namespace palpate::experiments {

/// The file of a scene that was placed on its body, with `mesh` as its mesh, a file in metres beside it, and
/// the regions where the body had them. Throws: InputError as read_yaml.
nlohmann::json placed_scene(const Scene& placed, const std::string& mesh);

/// A mapping whose values stand on a line each; lists of mappings a line an entry. JSON, which YAML reads.
std::string lines_of_scene(const nlohmann::json& scene);

}  // namespace palpate::experiments

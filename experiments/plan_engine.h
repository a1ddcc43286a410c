// What a plan of the contest engine adds: dynamic scenes.
#pragma once

#include <filesystem>
#include <vector>

#include "experiments/plan.h"
#include "experiments/yaml_value.h"

namespace palpate::experiments {

/// Reads the list of scenes, each a name of experiments/scenes or {name, file}, as in the contest deform.
/// Throws: InputError with file and line: for unknown scenes (with the nearest), one twice, a static one.
std::vector<PlanScene> read_dynamic_scenes(const YamlValue& value, const std::filesystem::path& folder);

/// Throws: InputError at `at` for a contestant that names a scene that the plan does not have (with the
/// nearest), or that asks for other vertices of a scene whose mesh is a file.
void check_scenes_of_contestants(const YamlValue& at, const Plan& plan);

/// Whether a contestant runs on the scene of that name.
bool runs_on(const PlanContestant& contestant, const std::string& scene);

}  // namespace palpate::experiments

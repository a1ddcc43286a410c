// The meshes of a plan.
#pragma once

#include <filesystem>
#include <vector>

#include "experiments/plan_reader/plan.h"
#include "experiments/text/yaml_value.h"

namespace palpate::experiments {

/// Reads the list of meshes: {name, make, ...} with the keys of shape_fields.h, or {name, file} with the file
/// relative to `folder`. Throws: InputError with file and line: a name twice, no such file, a shape's values.
std::vector<PlanMesh> read_meshes(const YamlValue& value, const std::filesystem::path& folder);

}  // namespace palpate::experiments

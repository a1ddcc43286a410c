// The scenes of a plan.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "experiments/plan_reader/plan.h"
#include "experiments/text/yaml_value.h"

namespace palpate::experiments {

/// What scenes a contest takes.
enum class SceneKind { kStatic, kDynamic };

/// Reads the list of scenes: names of experiments/scenes, or {name: ..., file: ...} with the file relative to
/// `folder`. Each is of the kind that `contest` takes. Throws: InputError with file and line, also for what a
/// scene itself has wrong.
std::vector<PlanScene> read_plan_scenes(const YamlValue& value, const std::filesystem::path& folder,
                                        SceneKind kind, const std::string& contest);

/// Throws: InputError if the sweep changes the vertices of a scene whose mesh is a file.
void check_vertices_sweep(const YamlFields& fields, const Plan& plan);

}  // namespace palpate::experiments

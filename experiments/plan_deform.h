// What a plan of the contests deform and motion adds: scenes, the reference, simplifiers.
#pragma once

#include <filesystem>
#include <vector>

#include "experiments/plan.h"
#include "experiments/yaml_value.h"

namespace palpate::experiments {

/// Reads the list of scenes: names of experiments/scenes, or {name: ..., file: ...} with the file relative to
/// `folder`. Each is a static scene in the contest deform, a dynamic one in the contest motion. Throws:
/// InputError with file and line, also for what a scene itself has wrong.
std::vector<PlanScene> read_plan_scenes(const YamlValue& value, const std::filesystem::path& folder,
                                        const std::string& contest);

/// Reads the reference: {method: fem.p2, levels: 3, enough: 0.002, stated_order: 2, set: {...}}.
/// In the contest motion without `enough`, and with two levels at least: the reference is to know its own
/// error. Throws: InputError with file and line, also for
/// a method without the integer option "refine", or, in the contest motion, without "time_step_s".
PlanReference read_reference(const YamlValue& value, const std::string& contest, const Registry& registry);

/// Reads `simplify`: simplifiers as in a contest of their own, and "none" for the mesh as it is. The sweep
/// tets_removed_ratio is theirs. Throws: InputError with file and line.
void read_simplifiers(const YamlFields& fields, Plan& plan, const Registry& registry);

/// Throws: InputError if a contestant has the label of the reference.
void check_reserved_labels(const YamlValue& contestants, const Plan& plan);

/// Throws: InputError if the sweep changes the vertices of a scene whose mesh is a file.
void check_vertices_sweep(const YamlFields& fields, const Plan& plan);

}  // namespace palpate::experiments

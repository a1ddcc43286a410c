// Reads a plan: what all contests have in common here, the rest by the contest that it names.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "experiments/plan_reader/plan.h"

namespace palpate::experiments {

/// The file of a plan that is given by its path, or by its bare name: `NAME` or `NAME.yaml` in the current
/// directory if there is one, otherwise in experiments/plans.
/// A path is returned as it is. Throws: InputError for a name that is in neither (with the nearest).
std::filesystem::path find_plan(const std::string& name);

/// Reads and checks a plan (palpate/plan/1): everything that can be checked without running anything.
///
/// Throws: InputError "file:line: ..." for unknown keys and names (with the nearest), wrong types, impossible
///         stops, labels twice, circles of tets_of, missing mesh files.
Plan read_plan(const std::filesystem::path& path, const Registry& registry);

/// The folders of contestants that a plan names beside those of the project (`contestant_folders`), absolute;
/// none for a file that is no plan: whatever else is wrong with it, read_plan says.
///
/// Throws: InputError "file:line: ..." if the file cannot be read, or a folder is none.
std::vector<std::filesystem::path> read_contestant_folders(const std::filesystem::path& path);

}  // namespace palpate::experiments

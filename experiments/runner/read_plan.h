// Reads a plan: what all contests have in common here, the rest by the contest that it names.
#pragma once

#include <filesystem>

#include "experiments/plan_reader/plan.h"

namespace palpate::experiments {

/// Reads and checks a plan (palpate/plan/1): everything that can be checked without running anything.
///
/// Throws: InputError "file:line: ..." for unknown keys and names (with the nearest), wrong types, impossible
///         stops, labels twice, circles of tets_of, missing mesh files.
Plan read_plan(const std::filesystem::path& path, const Registry& registry);

}  // namespace palpate::experiments

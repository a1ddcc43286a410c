// Where a run's figures come from: plan, code, machine, inputs.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "experiments/plan_reader/plan.h"
#include "experiments/registry/registry.h"

namespace palpate::experiments {

/// Time now in UTC as "2026-01-31T23:59:59Z", or without separators for names of files.
std::string utc_now(bool for_file_name = false);

/// Everything but the meshes: plan and its hash, commit and who says so, compiler, flags, library versions,
/// hashes of the programs that take part, processor, memory, load, seeds, threads, start time.
nlohmann::json build_provenance(const Plan& plan, const Registry& registry, int threads);

/// The provenance of a run.
/// Throws: InputError, with the file and the key, if it cannot be read, is none, or has something under one
///         of the keys that runs and gates go by that cannot stand there.
nlohmann::json read_provenance(const std::filesystem::path& file);

/// What a record's "sitting" stands for: when the run was started or resumed, at which commit and load.
nlohmann::json describe_sitting(const nlohmann::json& now);

/// What keeps a run from being continued, another processor or compiler among them: lines like "the plan
/// changed (xxh3:... then, xxh3:... now)". Empty if nothing does.
std::vector<std::string> find_changes(const nlohmann::json& then, const nlohmann::json& now);

}  // namespace palpate::experiments

// What the end of a repeat adds to its record and to the run folder, whatever the contest.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "experiments/contestants/contestant_run.h"
#include "experiments/plan_reader/case_list.h"
#include "experiments/processes/machine_load.h"
#include "experiments/registry/contestant.h"

namespace palpate::experiments {

/// An output that a full disk cut short is nobody's: the repeat gets no record, and is run again.
/// Throws: UnavailableError where that is so.
void throw_if_no_room(const std::filesystem::path& scratch, const nlohmann::json& record);

/// Adds what the machine did meanwhile. Of a child that was killed nobody knows what it took.
void add_load(const MachineLoad& load, const ContestantAnswer& answer, nlohmann::json& record);

/// Adds the hashes of the files that a case's options name: a changed file is another case, whatever its
/// name. The record keeps that name alone: where the file lies is this machine's business.
void add_file_hashes(const MethodSpec& method, const Case& c, nlohmann::json& record);

/// Where an output that is kept has what lies beside it (`name`: ContestFiles::beside_file).
std::filesystem::path beside_path(const std::filesystem::path& kept, const std::string& name);

/// Keeps what a contestant left beside its output and nobody judges; without it there is less to look at.
void keep_beside(const std::filesystem::path& output, const std::filesystem::path& kept,
                 const std::string& name);

}  // namespace palpate::experiments

// What a run must be before its figures are held against anything: whole, and from somewhere.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "experiments/records/run_rows.h"

namespace palpate::experiments {

/// What keeps a run's figures from being believed, one line each; empty if nothing does: plan.yaml or
/// provenance.json are missing or do not belong together; repeats of its cases are missing, or records name
/// cases that it does not have; a record that the plan requires is not accepted; any other one crashed, ran
/// out of memory, gave a bad answer, failed or was not judged. (A contestant that is not required may be
/// unavailable, be rejected, refuse its input or time out.)
std::vector<std::string> find_run_problems(const std::filesystem::path& folder, const RunRows& rows);

}  // namespace palpate::experiments

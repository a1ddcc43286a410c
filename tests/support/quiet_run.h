// Plans run in this process, and what they leave.
#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "experiments/runner/runner.h"
#include "tests/support/experiment_fixture.h"

namespace palpate::test {

/// Runs a plan without a word.
experiments::RunResult run_quietly(const ExperimentFixture& fixture, const std::filesystem::path& file,
                                   const std::filesystem::path& folder, bool resume = false,
                                   const std::string& case_id = "");

/// What it refuses the plan for; "no error" if it does not.
std::string run_error(const ExperimentFixture& fixture, const std::filesystem::path& plan,
                      const std::filesystem::path& folder, bool resume);

std::map<std::string, std::vector<nlohmann::json>> records_by_case(const std::filesystem::path& folder);

}  // namespace palpate::test

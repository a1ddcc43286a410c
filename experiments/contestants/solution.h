// A solution that something else is judged by or learns from: asked for once, kept, and checked for its end.
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "experiments/contestants/contestant_run.h"

namespace palpate::experiments {

/// After so many s a solve at rest is given up.
inline constexpr double kReferenceTimeout = 7200.0;

/// What came of it.
struct Solution {
  ContestantAnswer answer;  ///< to be read only where `failure` is empty and it was not interrupted
  bool was_kept = false;    ///< an earlier run made it
  bool interrupted = false;
  std::string outcome = "accepted";  ///< of its record
  std::string failure;               ///< why there is none: "ended: ..."; empty if there is
};

/// Solves the task, or takes what an earlier run kept; `further` as in run_cached. An answer whose report
/// does not say `wanted` ("converged", "completed") is none.
Solution solve(const ContestantTask& task, const std::string& wanted,
               std::span<const std::filesystem::path> further = {});

/// As records list it: how much it was refined, its time, whether it was kept, and its report.
nlohmann::json describe_solution(const Solution& solution, int refine);

}  // namespace palpate::experiments

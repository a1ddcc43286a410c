// Runs a plan: cases through the door, the judge on every answer, one record a repeat.
#pragma once

#include <csignal>
#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "experiments/contestants/contestant.h"
#include "experiments/plan_reader/plan.h"
#include "experiments/text/terminal.h"

namespace palpate::experiments {

struct RunOptions {
  std::filesystem::path folder;
  bool resume = false;
  bool retry_failed = false;      ///< run repeats of the selected cases anew that gave nothing to judge
  std::string case_id;            ///< empty: all
  std::vector<std::string> only;  ///< words and patterns (rounds/case_choice.h); empty: all
  std::optional<int> threads;     ///< in place of the plan's
  const volatile std::sig_atomic_t* stop_flag = nullptr;
};

/// What came of a run.
struct RunResult {
  std::map<std::string, std::map<std::string, std::size_t>> outcomes;  ///< label -> outcome -> cases
  std::map<std::string, std::string> failures;  ///< case -> first thing that went wrong
  std::size_t records_added = 0;
  bool required_rejected = false;  ///< a required case was judged and not accepted
  bool required_failed = false;    ///< a required case gave nothing to judge
  bool interrupted = false;
};

/// Throws: UnavailableError if a required contestant or a mesh of the plan cannot be had here.
void require_available(const Plan& plan, const Registry& registry);

/// Runs every repeat of every selected case that has no record yet.
///
/// Order: repeat 0 of all cases, then repeat 1 of all cases, and so on, each round in a random order that the
/// plan's `order_seed` sets (order_round), so that a drift of the machine meets all contestants alike; each
/// record says its position in its round. The first `warmup` repeats are recorded with warmup true. Where the
/// plan has `until_width`, a case is repeated until the interval of its median kernel time is so narrow, or
/// it has `most_repeats`. A case that timed out, refused its input or could not start is not repeated. The
/// same output as an earlier repeat's is not judged again; another output is a violation, unless the method's
/// description says that it is not deterministic: then it is judged. What a method's search found ("tuned")
/// in one repeat is handed back to it in the next. A repeat that failed while the disk had no room has no
/// record: the run ends, and a resumed one repeats it.
/// Throws: InputError for the folder (in use, not writable, another plan or program than before);
///         UnavailableError if a required contestant or a shape is missing, before anything runs, and where
///         the disk has no room.
RunResult run_plan(const Plan& plan, const Registry& registry, const RunOptions& options, Progress& progress);

}  // namespace palpate::experiments

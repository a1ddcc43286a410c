// Runs a plan: cases through the door, the judge on every answer, one record a repeat.
#pragma once

#include <csignal>
#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "experiments/plan_reader/plan.h"
#include "experiments/registry/registry.h"
#include "experiments/text/terminal.h"

namespace palpate::experiments {

struct RunOptions {
  std::filesystem::path folder;
  bool resume = false;
  bool retry_failed = false;      ///< run repeats of the selected cases anew that gave nothing to judge
  std::string case_id;            ///< empty: all
  std::vector<std::string> only;  ///< words and patterns (rounds/case_choice.h); empty: all
  std::string part;               ///< a file of cases, one a line; empty: all
  std::vector<std::filesystem::path> take;  ///< folders of other runs of the plan, whose repeats are taken
  bool prepare_only = false;   ///< make the inputs, the references and trained springs, and run nothing
  int jobs = 1;                ///< cases without times that run side by side
  std::optional<int> threads;  ///< in place of the plan's
  const volatile std::sig_atomic_t* stop_flag = nullptr;
};

/// What came of a run.
struct RunResult {
  std::map<std::string, std::map<std::string, std::size_t>> outcomes;  ///< label -> outcome -> cases
  std::map<std::string, std::string> failures;  ///< case -> first thing that went wrong
  std::size_t records_added = 0;
  bool is_whole = false;           ///< every repeat of the selected cases has its record
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
/// Repeats that other folders' runs of the plan have (`take`) are taken over, and not run (taken_parts.h).
/// With `jobs`, cases that are not timed run in so many processes of this program, each with a part of them
/// in a folder below the run's; what such a process leaves undone is run in the rounds. Their records are the
/// same as without it.
/// Throws: InputError for the folder (in use, not writable, another plan or program than before), or a part
///         that cannot be taken;
///         UnavailableError if a required contestant or a shape is missing, before anything runs, and where
///         the disk has no room.
RunResult run_plan(const Plan& plan, const Registry& registry, const RunOptions& options, Progress& progress);

}  // namespace palpate::experiments

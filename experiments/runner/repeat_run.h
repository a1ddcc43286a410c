// One repeat of a case: its contestant's process, the judge on what that left, the record of both.
#pragma once

#include <csignal>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "experiments/contests/contest.h"
#include "experiments/plan_reader/case_list.h"
#include "experiments/plan_reader/plan.h"
#include "experiments/records/run_folder.h"
#include "experiments/registry/registry.h"
#include "experiments/rounds/case_state.h"

namespace palpate::experiments {

/// The run that a repeat belongs to.
struct RepeatSetting {
  const Plan& plan;
  const Registry& registry;
  const RunFolder& folder;
  const Contest& contest;
  int threads = 1;
  const volatile std::sig_atomic_t* stop_flag = nullptr;
};

/// Which repeat is to be run.
struct RepeatTask {
  const Case& run_case;
  int repeat = 0;  ///< 0 is the first warm-up
  const CaseState& state;
  std::optional<Stop> stop;  ///< with tets_of resolved; null: the case that it needs left no mesh
  std::string not_run;       ///< why there is nothing to run (the record says it); empty: there is
};

/// Runs it, judges it, and keeps the output of the first repeat of a case in the run folder. Returns: its
/// record, without its place in the run; nothing if it was interrupted.
/// Throws: InputError where its output cannot be kept; UnavailableError where the disk has no room.
std::optional<nlohmann::json> run_repeat(const RepeatSetting& setting, RepeatTask task);

}  // namespace palpate::experiments

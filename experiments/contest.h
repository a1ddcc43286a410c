// What a contest brings of its own: inputs, requests and judgements. Plan, processes, rounds and records are
// the same for all.
#pragma once

#include <csignal>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "experiments/case_list.h"
#include "experiments/case_record.h"
#include "experiments/contestant_run.h"
#include "experiments/plan.h"
#include "experiments/run_folder.h"
#include "experiments/terminal.h"

namespace palpate::experiments {

/// What a contest needs of its run.
struct ContestSetting {
  const Plan& plan;
  const Registry& registry;
  const RunFolder& folder;
  int threads = 1;
  const volatile std::sig_atomic_t* stop_flag = nullptr;
  Progress& progress;
};

/// One contest over the life of a run.
class Contest {
 public:
  virtual ~Contest() = default;

  /// Makes the inputs of these cases below the run folder, or takes them up again: `earlier` is the
  /// provenance of an earlier start, or null. Returns what the provenance is to name of them, by its keys
  /// there. Throws: InputError if an input is no longer what `earlier` names.
  virtual nlohmann::json prepare(const std::vector<const Case*>& cases, const nlohmann::json& earlier) = 0;

  /// Appends the records of inputs that are not in `recorded` (by their case).
  /// Returns false if it was interrupted.
  virtual bool record_inputs(const std::set<std::string>& recorded,
                             const std::function<void(nlohmann::json)>& append) = 0;

  /// Fills the inputs of a request. Returns why the case cannot be run, empty if it can.
  virtual std::string fill_task(const Case& run_case, ContestantTask& task) const = 0;

  /// The record of a repeat, judged.
  virtual nlohmann::json build_record(const RepeatFacts& facts, const ContestantAnswer& answer,
                                      const std::vector<nlohmann::json>& earlier) const = 0;

  /// Where the first repeat's output of a case is kept.
  virtual std::filesystem::path kept_output(const Case& run_case) const = 0;
};

/// The bounds of the judge that a plan sets.
WorkBounds judge_bounds(const Plan& plan, const volatile std::sig_atomic_t* stop_flag);

std::unique_ptr<Contest> make_simplify_contest(const ContestSetting& setting);
std::unique_ptr<Contest> make_deform_contest(const ContestSetting& setting);
std::unique_ptr<Contest> make_verify_contest(const ContestSetting& setting);
std::unique_ptr<Contest> make_motion_contest(const ContestSetting& setting);
std::unique_ptr<Contest> make_engine_contest(const ContestSetting& setting);
std::unique_ptr<Contest> make_stability_contest(const ContestSetting& setting);

/// The contest that the plan names.
std::unique_ptr<Contest> make_contest(const ContestSetting& setting);

}  // namespace palpate::experiments

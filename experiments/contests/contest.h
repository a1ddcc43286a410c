// What a contest brings of its own: inputs, requests and judgements. Plan, processes, rounds and records are
// the same for all.
#pragma once

#include <csignal>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/mesh/tet_mesh.h"
#include "experiments/contestants/contestant_run.h"
#include "experiments/plan_reader/case_list.h"
#include "experiments/plan_reader/plan.h"
#include "experiments/records/case_record.h"
#include "experiments/records/run_folder.h"
#include "experiments/text/terminal.h"
#include "experiments/text/yaml_value.h"

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

/// Throws: RunInterrupted once the run is to stop.
void require_going_on(const ContestSetting& setting);

/// One contest over the life of a run.
class Contest {
 public:
  virtual ~Contest() = default;

  /// Makes the inputs of these cases below the run folder, or takes them up again: `earlier` is the
  /// provenance of an earlier start, or null. Returns what the provenance is to name of them, by its keys
  /// there. Throws: InputError if an input is no longer what `earlier` names; RunInterrupted.
  virtual nlohmann::json prepare(const std::vector<const Case*>& cases, const nlohmann::json& earlier) = 0;

  /// Appends the records of inputs that are not in `recorded` (by their case).
  /// Returns false if it was interrupted.
  virtual bool record_inputs(const std::set<std::string>& recorded,
                             const std::function<void(nlohmann::json)>& append) = 0;

  /// Fills the inputs of a request; `task` has all options of the case. Returns why the case cannot be run,
  /// empty if it can.
  virtual std::string fill_task(const Case& run_case, ContestantTask& task) const = 0;

  /// The record of a repeat, judged.
  virtual nlohmann::json build_record(const RepeatFacts& facts, const ContestantAnswer& answer,
                                      const std::vector<nlohmann::json>& earlier) const = 0;

  /// Where the first repeat's output of a case is kept.
  virtual std::filesystem::path kept_output(const Case& run_case) const = 0;
};

/// The bounds of the judge that a plan sets.
WorkBounds judge_bounds(const Plan& plan, const volatile std::sig_atomic_t* stop_flag);

/// A mesh as records name it: name, vertices, tets, hash of its file, mean volume of its tets.
nlohmann::json mesh_facts(const std::string& name, const TetMesh& mesh, const std::string& hash);

/// A task for an input of the run: a reference, a simplified mesh. Threads and stop flag are the run's.
ContestantTask start_task(const std::string& method, const std::filesystem::path& mesh,
                          const ContestSetting& setting);

/// A contest as plans name it.
struct ContestKind {
  std::string name;
  std::vector<std::string> keys;    ///< of its plans, beside those of every plan
  std::vector<std::string> needed;  ///< those of them without which there is no plan
  /// Keys of every plan that it does not take, each with the reason.
  std::vector<std::pair<std::string, std::string>> refused;
  std::vector<std::string> charts;  ///< that its plans may name, where "charts" is one of its keys
  /// Reads what the contest has of its own, subjects and contestants among it. The plan's file, name, contest
  /// and run are read. Throws: InputError with file and line.
  void (*read)(const YamlFields& fields, Plan& plan, const Registry& registry) = nullptr;
  std::vector<Case> (*build_cases)(const Plan& plan, const Registry& registry) = nullptr;
  std::unique_ptr<Contest> (*start)(const ContestSetting& setting) = nullptr;
};

}  // namespace palpate::experiments

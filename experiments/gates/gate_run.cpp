#include "experiments/gates/gate_run.h"

#include <set>

#include "core/base/error.h"
#include "experiments/files/file_hash.h"
#include "experiments/records/provenance.h"
#include "experiments/records/run_folder.h"

namespace palpate::experiments {
namespace fs = std::filesystem;
namespace {

using nlohmann::json;

/// The provenance of a run; null, and a problem, if there is none that can be read.
json look_at_provenance(const RunPaths& paths, std::vector<std::string>& problems) {
  if (!fs::exists(paths.provenance())) {
    problems.emplace_back("provenance.json is missing: nothing says what the figures come from");
    return {};
  }
  try {
    json provenance = read_provenance(paths.provenance());
    if (provenance.value("schema", json()) == "palpate/provenance/1") return provenance;
    problems.emplace_back("provenance.json is no palpate/provenance/1");
  } catch (const InputError& error) {
    problems.emplace_back(error.what());
  }
  return {};
}

void check_plan(const RunPaths& paths, const json& provenance, std::vector<std::string>& problems) {
  if (!fs::is_regular_file(paths.plan())) {
    problems.emplace_back("plan.yaml is missing");
  } else if (provenance.is_object() && provenance.value("plan_hash", json()) != hash_file(paths.plan())) {
    problems.emplace_back("plan.yaml is not the plan that provenance.json names");
  }
}

/// Figures are accepted for a plan: what says where they come from has to name the one that the records do.
void check_plan_name(const json& provenance, const RunRows& rows, std::vector<std::string>& problems) {
  const json named = provenance.value("plan", json());
  const std::string start = "provenance.json names the plan " + named.dump() + ", and records are of ";
  std::set<std::string> said;
  for (const RunRow& row : rows.all()) {
    const std::string own = row.plan->dump();
    if (named != *row.plan && said.insert(own).second) problems.push_back(start + own);
  }
}

bool is_closing(const std::string& outcome) {
  return outcome == "timed_out" || outcome == "bad_input" || outcome == "unavailable" ||
         outcome == "not_judged";
}

/// Outcomes that no run may hold, whether the contestant is required or not.
bool is_failure(const std::string& outcome) {
  static const std::set<std::string> failures{"crashed", "bad_answer", "error", "out_of_memory",
                                              "not_judged"};
  return failures.count(outcome) > 0;
}

void check_cases(const json& provenance, const RunRows& rows, std::vector<std::string>& problems) {
  const json cases = provenance.value("cases", json());
  const json repeats = provenance.value("repeats", json());
  const json warmup = provenance.value("warmup", json());
  if (!cases.is_array() || !repeats.is_number_integer() || !warmup.is_number_integer()) {
    problems.emplace_back(
        "provenance.json does not list the run's cases and repeats: it cannot be told whole");
    return;
  }
  const json own_repeats = provenance.value("repeats_of", json::object());
  std::set<std::string> known;
  for (const json& name : cases) {
    if (!name.is_string()) continue;
    const auto& id = *known.insert(name.get<std::string>()).first;
    std::set<std::int64_t> seen;
    bool closed = false;
    for (const RunRow* row : rows.of_case(id)) {
      seen.insert(row->repeat);
      closed = closed || is_closing(*row->outcome);
    }
    const auto wanted = own_repeats.value(id, repeats.get<std::int64_t>()) + warmup.get<std::int64_t>();
    const std::int64_t missing = wanted - static_cast<std::int64_t>(seen.size());
    if (missing > 0 && !closed)
      problems.push_back(id + ": " + std::to_string(missing) + " of its " + std::to_string(wanted) +
                         " repeats are missing");
  }
  std::set<std::string> strangers;
  for (const RunRow& row : rows.all()) {
    const std::string& id = *row.run_case;
    if (row.is_answer && known.count(id) == 0 && strangers.insert(id).second)
      problems.push_back(id + ": is no case of the run's plan");
  }
}

void check_outcomes(const RunRows& rows, std::vector<std::string>& problems) {
  std::set<std::pair<std::string, std::string>> said;
  for (const RunRow& row : rows.all()) {
    const std::string& outcome = *row.outcome;
    if (outcome == "accepted" || (!row.is_required && !is_failure(outcome))) continue;
    if (!said.insert({*row.run_case, outcome}).second) continue;
    problems.push_back(*row.run_case + ": " + outcome + (row.message != nullptr ? ": " + *row.message : ""));
  }
}

}  // namespace

std::vector<std::string> find_run_problems(const fs::path& folder, const RunRows& rows) {
  const RunPaths paths{folder};
  std::vector<std::string> problems;
  const json provenance = look_at_provenance(paths, problems);
  check_plan(paths, provenance, problems);
  if (provenance.is_object()) check_plan_name(provenance, rows, problems);
  if (provenance.is_object()) check_cases(provenance, rows, problems);
  check_outcomes(rows, problems);
  return problems;
}

}  // namespace palpate::experiments

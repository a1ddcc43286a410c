#include "experiments/gates/gate_run.h"

#include <algorithm>
#include <map>
#include <set>

#include "core/base/error.h"
#include "experiments/files/file_hash.h"
#include "experiments/judging/measure.h"
#include "experiments/records/run_folder.h"
#include "reference/door/json_file.h"

namespace palpate::experiments {
namespace fs = std::filesystem;
namespace {

using nlohmann::json;
using nlohmann::ordered_json;

/// The provenance of a run; null, and a problem, if there is none that can be read.
json read_provenance(const RunPaths& paths, std::vector<std::string>& problems) {
  if (!fs::exists(paths.provenance())) {
    problems.emplace_back("provenance.json is missing: nothing says what the figures come from");
    return {};
  }
  try {
    json provenance = reference::read_json_file(paths.provenance());
    if (provenance.is_object() && provenance.value("schema", json()) == "palpate/provenance/1")
      return provenance;
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

/// What the records hold of a case.
struct SeenCase {
  std::set<std::int64_t> repeats;
  bool closed = false;
};

void check_cases(const json& provenance, const std::vector<json>& records,
                 std::vector<std::string>& problems) {
  const json cases = provenance.value("cases", json());
  const json repeats = provenance.value("repeats", json());
  const json warmup = provenance.value("warmup", json());
  if (!cases.is_array() || !repeats.is_number_integer() || !warmup.is_number_integer()) {
    problems.emplace_back(
        "provenance.json does not list the run's cases and repeats: it cannot be told whole");
    return;
  }
  std::map<std::string, SeenCase> seen;
  for (const json& record : records) {
    SeenCase& own = seen[record.at("case").get<std::string>()];
    own.repeats.insert(record.at("repeat").get<std::int64_t>());
    own.closed = own.closed || is_closing(record.at("outcome").get<std::string>());
  }
  const json own_repeats = provenance.value("repeats_of", json::object());
  std::set<std::string> known;
  for (const json& name : cases) {
    if (!name.is_string()) continue;
    const auto& id = *known.insert(name.get<std::string>()).first;
    const SeenCase& own = seen[id];
    const auto wanted = own_repeats.value(id, repeats.get<std::int64_t>()) + warmup.get<std::int64_t>();
    const std::int64_t missing = wanted - static_cast<std::int64_t>(own.repeats.size());
    if (missing > 0 && !own.closed)
      problems.push_back(id + ": " + std::to_string(missing) + " of its " + std::to_string(wanted) +
                         " repeats are missing");
  }
  std::set<std::string> strangers;
  for (const json& record : records) {
    const auto id = record.at("case").get<std::string>();
    if (!record.value("contestant", json()).is_null() && known.count(id) == 0 && strangers.insert(id).second)
      problems.push_back(id + ": is no case of the run's plan");
  }
}

void check_outcomes(const std::vector<json>& records, std::vector<std::string>& problems) {
  std::set<std::pair<std::string, std::string>> said;
  for (const json& record : records) {
    const auto outcome = record.at("outcome").get<std::string>();
    if (outcome == "accepted" || (!record.value("required", true) && !is_failure(outcome))) continue;
    const auto id = record.at("case").get<std::string>();
    if (!said.insert({id, outcome}).second) continue;
    const json message = record.value("message", json());
    problems.push_back(id + ": " + outcome + (message.is_string() ? ": " + message.get<std::string>() : ""));
  }
}

/// Whether a figure comes from a clock or the system, and is another one in every run.
bool is_measured_time(const Measure& measure) {
  const std::string key = measure.key;
  for (const char* start :
       {"/kernel_s", "/wall_s", "/user_s", "/peak_rss_bytes", "/report/identify_s", "/report/solve_s",
        "/report/product_s", "/report/answer_s", "/reported/tick", "/reported/real_time_factor"}) {
    if (key.rfind(start, 0) == 0) return true;
  }
  return false;
}

std::vector<const Measure*> measures_of(const json& plan) {
  std::vector<const Measure*> measures;
  const auto add = [&](const std::string& name) {
    const Measure* measure = find_measure(name);
    if (measure == nullptr || !measure->scalar || is_measured_time(*measure)) return;
    if (std::find(measures.begin(), measures.end(), measure) == measures.end()) measures.push_back(measure);
  };
  for (const json& name : plan.value("measure", json::array())) {
    if (name.is_string()) add(name.get<std::string>());
  }
  const json accept = plan.value("accept", json::object());
  for (const auto& [name, bound] : accept.items()) add(name);
  return measures;
}

}  // namespace

std::vector<std::string> find_run_problems(const fs::path& folder, const std::vector<json>& records) {
  const RunPaths paths{folder};
  std::vector<std::string> problems;
  const json provenance = read_provenance(paths, problems);
  check_plan(paths, provenance, problems);
  if (provenance.is_object()) check_cases(provenance, records, problems);
  check_outcomes(records, problems);
  return problems;
}

ordered_json propose_accepted(const fs::path& folder, const std::vector<json>& records,
                              const std::string& plan) {
  const json provenance = reference::read_json_file(RunPaths{folder}.provenance());
  const auto measures = measures_of(provenance.value("plan_data", json::object()));
  ordered_json figures = ordered_json::array();
  std::set<std::string> done;
  for (const json& record : records) {
    const auto id = record.at("case").get<std::string>();
    if (record.at("outcome") != "accepted" || !done.insert(id).second) continue;
    for (const Measure* measure : measures) {
      if (!figure_of(record, *measure)) continue;
      figures.push_back({{"case", id},
                         {"measure", measure->name},
                         {"value", nullptr},
                         {"lower", 0},
                         {"upper", 0},
                         {"unit", measure->unit}});
    }
  }
  if (figures.empty())
    throw InputError(folder.string(), 0, "a plan whose \"measure\" or \"accept\" names figures to hold",
                     "none");
  return {{"schema", "palpate/accepted/1"}, {"plan", plan}, {"figures", std::move(figures)}};
}

}  // namespace palpate::experiments

#include "experiments/gates/gate.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string_view>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/number_text.h"
#include "experiments/judging/measure.h"
#include "experiments/records/record_file.h"
#include "experiments/text/nearest_name.h"
#include "experiments/text/terminal.h"
#include "reference/door/json_file.h"

namespace palpate::experiments {
namespace {

using nlohmann::ordered_json;

constexpr std::size_t kLargestFile = 64U << 20U;

ordered_json read_accepted(const std::filesystem::path& path) {
  if (!std::filesystem::exists(path))
    throw InputError(path.string(), 0, "accepted figures (palpate/accepted/1)", "no such file");
  const std::string text = reference::read_text_file(path, kLargestFile);
  ordered_json value = reference::parse_ordered_json(text, path.string());
  if (!value.is_object() || value.value("schema", ordered_json()) != "palpate/accepted/1") {
    throw InputError(path.string(), 0, "accepted figures (palpate/accepted/1)", "something else");
  }
  if (!value.value("figures", ordered_json()).is_array() || value.at("figures").empty()) {
    throw InputError(path.string(), 0, "a list \"figures\" that is not empty", "none");
  }
  return value;
}

GateLine read_line(const ordered_json& entry, const std::string& where) {
  static const std::vector<std::string> known{"case", "measure", "value", "lower", "upper", "unit"};
  if (!entry.is_object()) throw InputError(where, 0, "an object", entry.dump());
  for (const auto& [key, value] : entry.items()) {
    if (std::find(known.begin(), known.end(), key) == known.end()) {
      throw InputError(where + ": unknown key \"" + key + "\"" + nearest_hint(key, known));
    }
  }
  for (const std::string& key : known) {
    if (!entry.contains(key)) throw InputError(where + ": the key \"" + key + "\" is missing");
  }
  for (const char* key : {"case", "measure", "unit"}) {
    if (!entry.at(key).is_string()) throw InputError(where + ": " + key, 0, "text", entry.at(key).dump());
  }
  GateLine line;
  line.run_case = entry.at("case").get<std::string>();
  line.measure = entry.at("measure").get<std::string>();
  line.unit = entry.at("unit").get<std::string>();
  const Measure* measure = find_measure(line.measure);
  if (measure == nullptr || !measure->scalar) {
    throw InputError(where + ": unknown measure \"" + line.measure + "\"" +
                     nearest_hint(line.measure, measure_names()));
  }
  if (line.unit != measure->unit)
    throw InputError(where + ": unit of " + line.measure, 0, std::string("\"") + measure->unit + "\"",
                     "\"" + line.unit + "\"");
  for (const char* key : {"lower", "upper"}) {
    const ordered_json& value = entry.at(key);
    if (!value.is_number() || value.get<double>() < 0.0) {
      throw InputError(where + ": " + key, 0, "a tolerance of at least 0", value.dump());
    }
  }
  line.lower = entry.at("lower").get<double>();
  line.upper = entry.at("upper").get<double>();
  const ordered_json& value = entry.at("value");
  if (!value.is_number() && !value.is_null())
    throw InputError(where + ": value", 0, "a number", value.dump());
  if (value.is_number()) line.accepted = value.get<double>();
  return line;
}

/// Whether the figure is an error against a reference that is not good enough to tell it.
bool is_marked(const nlohmann::json& record, const Measure& measure) {
  static const nlohmann::json::json_pointer mark_place("/judge/reference_too_coarse");
  return std::string_view(measure.name).starts_with("displacement_") && record.contains(mark_place) &&
         record.at(mark_place) == true;
}

void measure_line(GateLine& line, const std::vector<nlohmann::json>& records) {
  const Measure& measure = *find_measure(line.measure);
  std::vector<double> values;
  for (const nlohmann::json& record : records) {
    if (record.at("case") != line.run_case || record.value("warmup", false)) continue;
    if (record.at("outcome") != "accepted") {
      line.problem = "a repeat is " + record.at("outcome").get<std::string>();
      return;
    }
    if (is_marked(record, measure)) {
      line.problem = "marked: its reference is not five times better";
      return;
    }
    const auto figure = figure_of(record, measure);
    if (!figure) {
      line.problem = "a repeat has no figure";
      return;
    }
    values.push_back(*figure);
  }
  if (values.empty()) {
    line.problem = "the run has no such case";
    return;
  }
  line.measured = median(std::move(values));
}

void compare(GateLine& line) {
  if (!line.problem.empty()) return;
  if (!line.accepted) {
    line.problem = "no accepted value yet";
  } else if (*line.measured < *line.accepted - line.lower) {
    line.problem = "below the lower bound";
  } else if (*line.measured > *line.accepted + line.upper) {
    line.problem = "above the upper bound";
  }
}

}  // namespace

bool GateResult::holds() const {
  return problems.empty() &&
         std::all_of(lines.begin(), lines.end(), [](const GateLine& line) { return line.problem.empty(); });
}

GateResult hold_against(const std::vector<nlohmann::json>& records, const std::string& plan,
                        const std::filesystem::path& accepted_file) {
  const ordered_json accepted = read_accepted(accepted_file);
  if (accepted.value("plan", ordered_json()) != plan) {
    throw InputError(accepted_file.string(), 0, "figures of the plan " + plan,
                     accepted.value("plan", ordered_json()).dump());
  }
  GateResult result;
  std::set<std::pair<std::string, std::string>> seen;
  std::size_t number = 0;
  for (const ordered_json& entry : accepted.at("figures")) {
    const std::string where = accepted_file.string() + ": figure " + std::to_string(++number);
    GateLine line = read_line(entry, where);
    if (!seen.insert({line.run_case, line.measure}).second) throw InputError(where + ": twice");
    measure_line(line, records);
    compare(line);
    result.lines.push_back(std::move(line));
  }
  return result;
}

std::vector<std::string> update_accepted(const GateResult& result,
                                         const std::filesystem::path& accepted_file) {
  ordered_json accepted = read_accepted(accepted_file);
  std::vector<std::string> changes;
  require(accepted.at("figures").size() == result.lines.size(), "update_accepted: another file");
  for (std::size_t i = 0; i < result.lines.size(); ++i) {
    const GateLine& line = result.lines[i];
    if (!line.measured || line.measured == line.accepted) continue;
    accepted["figures"][i]["value"] = *line.measured;
    changes.push_back(line.run_case + " " + line.measure + ": " +
                      (line.accepted ? short_number(*line.accepted) : "none") + " -> " +
                      short_number(*line.measured) + " " + line.unit);
  }
  if (!changes.empty()) write_file_atomically(accepted_file, accepted.dump(2) + "\n");
  return changes;
}

}  // namespace palpate::experiments

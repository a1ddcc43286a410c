#include "experiments/plan_reader/plan_report.h"

#include <algorithm>

#include "experiments/text/nearest_name.h"

namespace palpate::experiments {
namespace {

/// At 9 repeats the 95% interval of a median (report/shared/intervals.py) leaves the least and the greatest
/// out.
constexpr int kLeastTimedRepeats = 9;
constexpr int kLeastWarmup = 1;

bool has_enough_repeats(const RunSettings& run) {
  return run.repeats >= kLeastTimedRepeats && run.warmup >= kLeastWarmup;
}

}  // namespace

std::string known_label(const YamlValue& value, const std::vector<PlanContestant>& contestants) {
  std::vector<std::string> labels;
  labels.reserve(contestants.size());
  for (const PlanContestant& contestant : contestants) labels.push_back(contestant.label);
  std::string label = value.text();
  if (std::find(labels.begin(), labels.end(), label) == labels.end()) {
    value.fail("unknown label \"" + label + "\"" + nearest_hint(label, labels));
  }
  return label;
}

void add_once(const YamlValue& at, const char* what, std::string name, std::vector<std::string>& names) {
  if (std::find(names.begin(), names.end(), name) != names.end()) {
    at.fail(std::string(what) + " \"" + name + "\" twice");
  }
  names.push_back(std::move(name));
}

std::vector<std::string> read_tags(const YamlFields& fields) {
  std::vector<std::string> tags;
  const auto value = fields.find("tags");
  if (!value) return tags;
  for (const YamlValue& item : value->items()) add_once(item, "tag", item.identifier(), tags);
  if (tags.empty()) value->fail_expected("at least one tag");
  return tags;
}

bool is_clock_time(const std::string& measure) {
  const Measure* known = find_measure(measure);
  return known != nullptr && is_clock_time(*known);
}

void require_repeats(const YamlValue& at, const RunSettings& run) {
  if (!run.timed) at.fail("times are compared, and the plan says \"timed: false\"");
  if (has_enough_repeats(run)) return;
  at.fail("times are compared by at least " + std::to_string(kLeastTimedRepeats) + " repeats and " +
          std::to_string(kLeastWarmup) + " warm-up: expected run: {repeats: " +
          std::to_string(kLeastTimedRepeats) + ", warmup: " + std::to_string(kLeastWarmup) +
          "} or more, found {repeats: " + std::to_string(run.repeats) +
          ", warmup: " + std::to_string(run.warmup) + "}");
}

const Measure& known_measure(const YamlValue& at, const std::string& name, bool scalar) {
  const Measure* measure = find_measure(name);
  if (measure == nullptr) at.fail("unknown measure \"" + name + "\"" + nearest_hint(name, measure_names()));
  if (scalar && !measure->scalar) at.fail("measure \"" + name + "\" is a list, a single number is needed");
  return *measure;
}

AcceptBound read_bound(const std::string& measure, const YamlValue& value) {
  known_measure(value, measure, true);
  const YamlFields fields = value.fields({"min", "max"});
  AcceptBound bound{measure, std::nullopt, std::nullopt};
  if (const auto min = fields.find("min")) bound.min = min->number();
  if (const auto max = fields.find("max")) bound.max = max->number();
  if (!bound.min && !bound.max) value.fail(measure + ": expected min or max");
  if (bound.min && bound.max && *bound.min > *bound.max) value.fail(measure + ": min is above max");
  return bound;
}

void check_required(const YamlFields& fields) {
  if (const auto required = fields.find("required")) required->boolean();
}

bool requires_report(const std::filesystem::path& plan) {
  const nlohmann::json data = read_yaml(plan).json();
  const auto is_required = [](const nlohmann::json& entry) { return entry.value("required", false); };
  for (const char* key : {"comparisons", "targets"}) {
    const nlohmann::json entries = data.value(key, nlohmann::json::array());
    if (std::any_of(entries.begin(), entries.end(), is_required)) return true;
  }
  return is_required(data.value("claim", nlohmann::json::object()));
}

std::string timing_note(const Plan& plan) {
  std::string named;
  for (const std::string& measure : plan.measure) {
    if (is_clock_time(measure)) named += (named.empty() ? "" : ", ") + measure;
  }
  if (named.empty() || has_enough_repeats(plan.run)) return "";
  return "times (" + named + ") come from " + std::to_string(plan.run.repeats) +
         (plan.run.repeats == 1 ? " repeat" : " repeats") +
         (plan.run.warmup > 0 ? "" : " without a warm-up") + ": they are shown and compare nothing (" +
         std::to_string(kLeastTimedRepeats) + " and a warm-up are asked for)";
}

std::vector<std::string> read_charts(const YamlValue& value, const std::vector<std::string>& known) {
  std::vector<std::string> charts;
  for (const YamlValue& item : value.items()) {
    const std::string name = item.text();
    if (std::find(known.begin(), known.end(), name) == known.end()) {
      item.fail("unknown chart \"" + name + "\"" + nearest_hint(name, known));
    }
    add_once(item, "chart", name, charts);
  }
  return charts;
}

}  // namespace palpate::experiments

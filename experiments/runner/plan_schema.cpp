#include "experiments/runner/plan_schema.h"

#include <algorithm>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "experiments/runner/contest_table.h"

namespace palpate::experiments {
namespace {

using nlohmann::ordered_json;

bool has(const std::vector<std::string>& keys, const std::string& key) {
  return std::find(keys.begin(), keys.end(), key) != keys.end();
}

/// Which keys a contest has not, and which it needs.
ordered_json describe_contest(const ContestKind& kind) {
  ordered_json properties = {{"contest", {{"const", kind.name}}}};
  for (const std::string& key : list_plan_keys()) {
    if (!has(keys_of_every_plan(), key) && !has(kind.keys, key)) properties[key] = false;
  }
  for (const auto& [key, why] : kind.refused) properties[key] = false;
  return {{"properties", properties}, {"required", kind.needed}};
}

ordered_json list_charts() {
  ordered_json charts = ordered_json::array();
  for (const ContestKind* kind : list_contests()) {
    for (const std::string& chart : kind->charts) charts.push_back(chart);
  }
  return charts;
}

/// What values look like, in the order of the keys.
ordered_json describe_values(const ordered_json& given) {
  ordered_json values = ordered_json::object();
  for (const std::string& key : list_plan_keys()) {
    if (!given.contains(key))
      throw InputError("plan_values.json", 0, "what values of " + key + " look like", "none");
    values[key] = given.at(key);
  }
  for (const auto& [key, value] : given.items()) {
    if (!values.contains(key)) throw InputError("plan_values.json", 0, "keys of plans", key);
  }
  values["contest"]["enum"] = ordered_json::array();
  for (const ContestKind* kind : list_contests()) values["contest"]["enum"].push_back(kind->name);
  values["charts"]["items"] = {{"enum", list_charts()}};
  return values;
}

/// A list or object with a line an entry.
std::string lines_of(const ordered_json& value) {
  std::string text;
  for (const auto& [key, entry] : value.items())
    text += (text.empty() ? "\n  " : ",\n  ") + (value.is_object() ? ordered_json(key).dump() + ": " : "") +
            entry.dump();
  return value.is_object() ? "{" + text + "\n}" : "[" + text + "\n]";
}

}  // namespace

std::string write_plan_schema(const ordered_json& values) {
  ordered_json contests = ordered_json::array();
  for (const ContestKind* kind : list_contests()) contests.push_back(describe_contest(*kind));
  const ordered_json schema = {{"$schema", "https://json-schema.org/draft/2020-12/schema"},
                               {"title", "palpate/plan/1: one question, as data"},
                               {"type", "object"},
                               {"additionalProperties", false},
                               {"required", {"schema", "question", "contest", "contestants"}},
                               {"oneOf", contests},
                               {"properties", describe_values(values.at("properties"))},
                               {"$defs", values.at("$defs")}};
  std::string text;
  for (const auto& [key, value] : schema.items()) {
    const bool is_long = key == "oneOf" || key == "properties" || key == "$defs";
    text += (text.empty() ? "{\n\"" : ",\n\"") + key + "\": " + (is_long ? lines_of(value) : value.dump());
  }
  return text + "\n}\n";
}

}  // namespace palpate::experiments

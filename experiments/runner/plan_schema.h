// experiments/schema/plan.schema.json, made from the table of contests.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace palpate::experiments {

/// The schema of plans as JSON, a line a key. Which keys there are, which of them each contest has, needs and
/// refuses, and the names of contests and charts come from the table of contests; what values look like comes
/// from `values` (experiments/schema/plan_values.json): "properties" by key, and "$defs".
/// Throws: InputError if `values` lacks a key of plans or has one that is none.
std::string write_plan_schema(const nlohmann::ordered_json& values);

}  // namespace palpate::experiments

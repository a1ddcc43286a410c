// The reference of a plan: what its answers are judged by.
#pragma once

#include <string>

#include "experiments/plan_reader/plan.h"
#include "experiments/text/yaml_value.h"

namespace palpate::experiments {

/// Reads the reference: {method: fem.p2, levels: 3, enough: 0.002, stated_order: 2, set: {...}}.
/// In the contest motion without `enough`, and with two levels at least: the reference is to know its own
/// error. Throws: InputError with file and line, also for a method without the integer option "refine", or,
/// in the contest motion, without "time_step_s".
PlanReference read_reference(const YamlValue& value, const std::string& contest, const Registry& registry);

/// Throws: InputError if a contestant has the label of the reference.
void check_reserved_labels(const YamlValue& contestants, const Plan& plan);

}  // namespace palpate::experiments

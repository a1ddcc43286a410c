// The contestants of a plan, and their stops.
#pragma once

#include <vector>

#include "experiments/plan.h"
#include "experiments/yaml_value.h"

namespace palpate::experiments {

/// The value of a stop, checked against its kind: counts are whole and not negative, a ratio is in [0, 1).
double read_stop_value(StopKind kind, const YamlValue& value);

/// Reads the list of contestants; `plan` holds its contest and its sweep already.
/// Throws: InputError with file and line.
std::vector<PlanContestant> read_contestants(const YamlValue& value, const Plan& plan,
                                             const Registry& registry);

}  // namespace palpate::experiments

// The contestants of a plan, and their stops.
#pragma once

#include <vector>

#include "experiments/plan_reader/plan.h"
#include "experiments/text/yaml_value.h"

namespace palpate::experiments {

/// Reads a list of contestants of one contest, held against the plan's sweep (the axes of `contest` alone).
/// Throws: InputError with file and line.
std::vector<PlanContestant> read_contestants(const YamlValue& value, const std::string& contest,
                                             const std::vector<SweepAxis>& sweep, const Registry& registry);

/// The method of that name. Throws: InputError at `at` for an unknown one (with the nearest), or one of
/// another contest.
MethodEntry find_method(const YamlValue& at, const std::string& name, const std::string& contest,
                        const Registry& registry);

/// The options that a mapping sets. Throws: InputError with file and line for one that `method` does not
/// have.
std::map<std::string, GivenOption> read_set(const YamlValue& value, const MethodSpec& method);

/// Whether a contestant runs on the scene of that name.
bool runs_on(const PlanContestant& contestant, const std::string& scene);

}  // namespace palpate::experiments

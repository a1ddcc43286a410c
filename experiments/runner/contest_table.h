// The contests that there are: one line each.
#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "experiments/contests/contest.h"

namespace palpate::experiments {

/// All contests, in the order in which they are named to users.
const std::vector<const ContestKind*>& list_contests();

/// All keys that a plan may have, those of every plan first.
std::vector<std::string> list_plan_keys();

/// What experiments/schema/plan.schema.json says of the contests, its key "oneOf": which keys each has, needs
/// and refuses.
nlohmann::json describe_plan_keys();

/// The cases of a plan, by its contest. Throws: InputError if two have one id.
std::vector<Case> build_cases(const Plan& plan, const Registry& registry);

/// Starts the contest that the plan names.
std::unique_ptr<Contest> make_contest(const ContestSetting& setting);

}  // namespace palpate::experiments

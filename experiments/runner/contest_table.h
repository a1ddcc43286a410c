// The contests that there are: one line each.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "experiments/contests/contest.h"

namespace palpate::experiments {

/// All contests, in the order in which they are named to users.
const std::vector<const ContestKind*>& list_contests();

/// The keys of every plan, whatever its contest.
const std::vector<std::string>& keys_of_every_plan();

/// All keys that a plan may have, those of every plan first.
std::vector<std::string> list_plan_keys();

/// The cases of a plan, by its contest. Throws: InputError if two have one id.
std::vector<Case> build_cases(const Plan& plan, const Registry& registry);

/// Starts the contest that the plan names.
std::unique_ptr<Contest> make_contest(const ContestSetting& setting);

}  // namespace palpate::experiments

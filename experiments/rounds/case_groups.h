// Cases that belong together wherever a plan is split.
#pragma once

#include <cstddef>
#include <vector>

#include "experiments/plan_reader/case_list.h"

namespace palpate::experiments {

/// The first case of each case's group: a case and what it needs (Case::tets_of, Case::coarser) are of one;
/// so are all cases of one mesh or scene that `is_timed` marks.
std::vector<std::size_t> group_cases(const std::vector<Case>& cases, const std::vector<bool>& is_timed);

/// Whether each case has times: its contestant's word, or else the plan's.
std::vector<bool> find_timed(const Plan& plan, const std::vector<Case>& cases);

/// The cases that may run beside others: not timed, and in need of none that is.
std::vector<bool> find_free(const std::vector<Case>& cases, const std::vector<bool>& is_timed);

}  // namespace palpate::experiments

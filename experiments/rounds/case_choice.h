// Which cases of a plan a run is asked for.
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "experiments/plan_reader/case_list.h"
#include "experiments/plan_reader/plan.h"

namespace palpate::experiments {

/// What a run is asked for. Nothing: all cases.
struct CaseChoice {
  std::string case_id;            ///< a case, or what cases start with ("kidney/hierarchical"); empty: any
  std::vector<std::string> only;  ///< words and patterns; a case that one of them fits is taken; empty: any
  std::string part{};             ///< a file of whole ids, one a line; empty: any

  bool is_all() const { return case_id.empty() && only.empty() && part.empty(); }
};

/// The indices of the cases that are chosen, with the cases that they need, in the plan's order.
///
/// A word of `only` fits a case if it is its id, the name of its mesh, scene or known case, its label, or a
/// tag of either; with *, ? or [ in it, it is a pattern for the whole id, in which * stands for slashes too.
/// Throws: InputError for a word or a pattern that fits no case (with the nearest), an id of the part that is
/// no case's, or if no case is left.
std::vector<std::size_t> choose_cases(const Plan& plan, const std::vector<Case>& cases,
                                      const CaseChoice& choice);

/// The choice as the provenance of a run states it: {"case": ..., "only": [...]}; null for all cases.
nlohmann::json describe_choice(const CaseChoice& choice);

}  // namespace palpate::experiments

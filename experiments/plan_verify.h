// What a plan of the contest verify adds: cases with a known answer, and what each contestant is to reach on
// them.
#pragma once

#include <vector>

#include "experiments/case_list.h"
#include "experiments/plan.h"
#include "experiments/yaml_value.h"

namespace palpate::experiments {

/// Reads the list of cases:
///
///   - case: manufactured                 # of reference/closed_form
///     cells: [4, 8, 16]                  # one mesh each, rising
///     expect:
///       - {contestants: [fem.p1], solution_order: {min: 1.9}}
///
/// A contestant runs on the cases that expect something of it. The bounds hold on the last mesh;
/// solution_order is the one from the last mesh but one. Throws: InputError with file and line: for unknown
/// cases, labels and measures (with the nearest), cells that do not rise, a contestant that nothing is
/// expected of.
std::vector<PlanKnownCase> read_known_cases(const YamlValue& value,
                                            const std::vector<PlanContestant>& contestants);

/// The cases of such a plan, "manufactured/fem.p1/cells=8", each contestant from coarse to fine.
std::vector<Case> build_verify_cases(const Plan& plan, const Registry& registry);

/// What is expected of a label on a case; nothing if it does not run there.
const KnownCaseExpectation* find_expectation(const PlanKnownCase& known, const std::string& label);

}  // namespace palpate::experiments

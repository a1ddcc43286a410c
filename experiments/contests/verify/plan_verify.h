// What a plan of the contest verify adds: cases with a known answer, and what each contestant is to reach on
// them.
#pragma once

#include <string>
#include <vector>

#include "experiments/plan_reader/case_list.h"
#include "experiments/plan_reader/plan.h"
#include "experiments/text/yaml_value.h"

namespace palpate::experiments {

/// What some contestants are to reach on a case with a known answer, on its finest mesh.
struct KnownCaseExpectation {
  std::vector<std::string> labels;
  std::vector<AcceptBound> bounds;
};

/// A case with a known answer, of reference/closed_form.
struct PlanKnownCase {
  std::string name;
  std::vector<int> cells;  ///< one mesh each, rising
  std::vector<KnownCaseExpectation> expect;
};

/// What the contest verify alone reads.
struct VerifyPart : ContestPart {
  std::vector<PlanKnownCase> known_cases;
};

/// Reads it (see ContestKind::read), with its list of cases:
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
void read_verify_plan(const YamlFields& fields, Plan& plan, const Registry& registry);

/// The cases of such a plan, "manufactured/fem.p1/cells=8", each contestant from coarse to fine.
std::vector<Case> build_verify_cases(const Plan& plan, const Registry& registry);

/// What is expected of a label on a case; nothing if it does not run there.
const KnownCaseExpectation* find_expectation(const PlanKnownCase& known, const std::string& label);

}  // namespace palpate::experiments

// The frontier of a contest of displacements: read, checked, and left to the report.
#pragma once

#include "experiments/plan_reader/plan.h"
#include "experiments/text/yaml_value.h"

namespace palpate::experiments {

/// Reads and checks the key "frontier" of a plan, if it has it:
///
///   frontier:
///     of: contestants                     # or simplifiers: the labels of the key simplify
///     families: {springs: [van_gelder, opposite], linear elements: [fem_p1]}
///     against: [linear elements]
///     at: [0.1, 0.05, 0.02, 0.01]
///     targets: [{work: first, against: linear elements, at: 0.05, factor: 20}]
///
/// Every label of what it is of belongs to one family. `against` names those that the others' times are
/// divided by, `at` the errors at which times are compared. A target is a factor between the fastest of all
/// other families and the one that it is held against, in the work of a first answer, a further one, or a
/// simulated second. The plan gets the families; the report reads the rest from the plan itself
/// (report/deform/frontier.py). Requires: plan.contestants are read. Throws: InputError with file and line
/// for an unknown label or family (with the nearest), a label in two families or in none, an error that is
/// not in (0, 10].
void check_frontier(const YamlFields& fields, Plan& plan);

}  // namespace palpate::experiments

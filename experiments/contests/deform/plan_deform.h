// What a plan of the contest deform adds: scenes, the reference, simplifiers, targets.
#pragma once

#include "experiments/plan_reader/plan.h"
#include "experiments/text/yaml_value.h"

namespace palpate::experiments {

/// Reads it: see ContestKind::read. Throws: InputError with file and line.
void read_deform_plan(const YamlFields& fields, Plan& plan, const Registry& registry);

}  // namespace palpate::experiments

// What a plan of the contest engine adds: dynamic scenes, and where each contestant runs.
#pragma once

#include "experiments/plan_reader/plan.h"
#include "experiments/text/yaml_value.h"

namespace palpate::experiments {

/// Reads it: see ContestKind::read. Throws: InputError with file and line,
/// also for a contestant that names a scene that the plan does not have, or asks for other vertices of a
/// scene whose mesh is a file.
void read_engine_plan(const YamlFields& fields, Plan& plan, const Registry& registry);

}  // namespace palpate::experiments

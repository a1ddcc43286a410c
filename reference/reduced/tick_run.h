// reduced.ticks: the loop of a haptic device on a table of compliances.
#pragma once

#include "reference/door/adapter.h"

namespace palpate::reference {

/// Answers a request of the contest engine: ticks of a loop in which the tool of a dynamic scene is where its
/// profile has it, and the force on it is what the body at rest under it gives, by a table of the free body's
/// compliances (core/dynamics/reduced/compliance_answer.h). Inertia and damping are left out, and a large
/// strain is taken for a small one, with a note. The scene's own model is not used.
///
/// The report is that of engine.ticks, with identify_s (the table), prepare_s (the holding),
/// skin_table_bytes and touched_components. Throws: InputError as HeldBody does, and for loads that come or
/// go, another number of tools than one, or a tool that shares vertices with a clamp.
Response run_compliance_ticks(const Request& request);

}  // namespace palpate::reference

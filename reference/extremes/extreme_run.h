// Requests of motion.* in the contest stability, and the way from there to the response.
#pragma once

#include "reference/door/adapter.h"

namespace palpate::reference {

/// Answers a request of the contest stability (reference/PROTOCOL.md): builds the body, predicts its longest
/// stable step, measures it, and runs with steps around and beyond it; or runs with one step. The report has
/// no number that is not finite: what there is none of is null. Throws: InputError for an unknown method or
/// option, or a body that cannot be had.
Response run_extreme(const Request& request);

}  // namespace palpate::reference

// Requests of springs.* and smoothed.* as a model, and the way from there to the response.
#pragma once

#include "reference/door/adapter.h"

namespace palpate::reference {

/// Answers a request of the contest deform: identifies springs or builds smoothed elements, finds the static
/// equilibrium (small strain: one linearised solve; large: Newton's method), and writes the displacement if
/// it converged. Throws: InputError for an unknown method or option, a ratio that the method cannot
/// represent, or a rigid motion that is left free.
Response run_model(const Request& request);

}  // namespace palpate::reference

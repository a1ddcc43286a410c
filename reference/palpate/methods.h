// Our own simplifiers: each reads its options from a request, runs and reports.
#pragma once

#include "reference/door/adapter.h"

namespace palpate::reference {

/// palpate.hierarchical. Throws, as all here: InputError for options or a mesh that make no sense.
Response run_hierarchical(const Request& request);

/// palpate.outcome.
Response run_outcome(const Request& request);

/// palpate.refined.
Response run_refined(const Request& request);

/// palpate.surface.
Response run_surface(const Request& request);

}  // namespace palpate::reference

// reduced.pod at rest: trained on loads drawn for the body's own supports, and asked for one that it never
// saw.
#pragma once

#include "reference/door/adapter.h"

namespace palpate::reference {

/// Answers reduced.pod of the contest deform. Throws: InputError as adapters do; for small strain.
Response run_pod(const Request& request);

}  // namespace palpate::reference

// reduced.compliance: a request of the contest deform.
#pragma once

#include "reference/door/adapter.h"

namespace palpate::reference {

/// Makes or reads the table of the request's mesh and answers its problem. Throws: InputError for a bad
/// request, large strain, a table of another body, or a load that no table knows.
Response run_compliance(const Request& request);

}  // namespace palpate::reference

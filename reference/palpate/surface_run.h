// Requests of palpate.surface as an options struct, and its report.
#pragma once

#include "reference/adapter.h"

namespace palpate::reference {

/// Reads the mesh, simplifies it by simplify_surface (the timed kernel), writes the result and reports.
/// Throws: InputError for a wrong option or stop.
Response run_surface(const Request& request);

}  // namespace palpate::reference

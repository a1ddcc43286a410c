// graded.edge_node: smoothed elements on as many vertices as the organ has, elsewhere; at the door.
#pragma once

#include "reference/door/adapter.h"

namespace palpate::reference {

/// Answers a request. Throws: InputError for what it cannot do.
Response run_graded(const Request& request);

}  // namespace palpate::reference

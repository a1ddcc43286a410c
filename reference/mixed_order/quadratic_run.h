// fem.p2_patch and fem.p2_coarse: quadratic elements where they count, at the door.
#pragma once

#include "reference/door/adapter.h"

namespace palpate::reference {

/// Answers a request of one of the two. Throws: InputError for what they cannot do.
Response run_quadratic(const Request& request);

}  // namespace palpate::reference

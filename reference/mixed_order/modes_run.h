// fem.p1_modes: linear elements and learnt error modes, at the door.
#pragma once

#include "reference/door/adapter.h"

namespace palpate::reference {

/// Answers a request. Throws: InputError for what it cannot do.
Response run_modes(const Request& request);

}  // namespace palpate::reference

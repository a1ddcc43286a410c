// reduced.modal at rest (contest deform) and moving_reduced.modal in motion.
#pragma once

#include "reference/door/adapter.h"

namespace palpate::reference {

/// The body at rest by its modes and the static correction of each load. Throws: InputError for a bad request
/// or large strain.
Response run_modal_at_rest(const Request& request);

/// The history of a motion. Throws: InputError for a bad request, large strain, or a body that is not held in
/// every phase.
Response run_modal_motion(const Request& request);

}  // namespace palpate::reference

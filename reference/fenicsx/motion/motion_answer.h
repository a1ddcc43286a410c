// moving_fem.p1 and moving_fem.p2: a request of the contest motion.
#pragma once

#include "reference/door/adapter.h"

namespace palpate::reference::fenicsx {

/// Answers a request: the history by Newmark's method, and the frequencies that it asks for.
/// Throws: InputError for a bad request.
Response answer_motion(const Request& request);

}  // namespace palpate::reference::fenicsx

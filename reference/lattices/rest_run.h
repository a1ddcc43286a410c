// lattice.*: a request of the contest deform.
#pragma once

#include "reference/door/adapter.h"

namespace palpate::reference {

/// Answers a request of lattice.hexahedral and lattice.bcc: one linear solve over the lattice's nodes, and
/// its field at the mesh's vertices. Throws: InputError for a bad request, large strain, or a rigid motion
/// that is left free.
Response run_lattice_at_rest(const Request& request);

}  // namespace palpate::reference

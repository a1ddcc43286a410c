// reduced.modal at rest (contest deform), moving_reduced.modal in motion, and reduced.modal_ticks (contest
// engine).
#pragma once

#include "reference/door/adapter.h"

namespace palpate::reference {

/// The body at rest by its modes and the static correction of each load. Throws: InputError for a bad request
/// or large strain.
Response run_modal_at_rest(const Request& request);

/// The history of a motion. Throws: InputError for a bad request, large strain, or a body that is not held in
/// every phase.
Response run_modal_motion(const Request& request);

/// Ticks of the loop of a haptic device: each is one exact step for a tool that runs straight over it, and
/// the tool's force is that of modes and static correction (core/dynamics/reduced/modal_phase.h). The model
/// of the scene is not used; a large strain is taken for a small one, with a note.
///
/// The report is that of engine.ticks, with identify_s (elements and modes), mode_bytes and unknowns. Throws:
/// InputError for loads that come or go, another number of tools than one, a body that is left free, and as
/// ModalPhase.
Response run_modal_ticks(const Request& request);

}  // namespace palpate::reference

// reduced.modal at rest (contest deform), moving_reduced.modal in motion, reduced.modal_ticks and
// reduced.modal_replay (contest engine).
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

/// A dynamic scene from start to end. Of its stepping, the number of frames is used alone; a large strain is
/// taken for a small one, with a note.
///
/// The answer is that of engine.replay with the columns of a motion's history and largest_displacement_m,
/// rms_displacement_m and largest_speed_m_s. Its report has setup_s (elements, and the modes of each holding
/// once), kernel_s (steps alone), inverted_tets_most and peak_speed_m_s over the rows, and left_out_at_phases
/// as moving_reduced.modal. Throws: InputError for a body that is not held in every phase, and as ModalPhase.
Response run_modal_replay(const Request& request);

}  // namespace palpate::reference

// reduced.modal_replay: a dynamic scene by its modes.
#pragma once

#include <csignal>
#include <functional>

#include "reference/door/adapter.h"

namespace palpate::reference {

/// A dynamic scene from start to end on the lowest modes of each holding: all modes first, then all steps.
/// The options are its own, whatever model the scene has; where that is reduced.modal, large strain is
/// refused, else taken for a small one, with a note. Of the stepping of the scene, the number of frames is
/// used alone.
///
/// The answer is that of engine.replay, with its columns; with a folder in the request, history.csv and
/// frames are written there. Its report has setup_s (elements, and the modes of each holding once), kernel_s
/// (steps alone), kernel_samples_s (all steps again, as often as the option `timings` says), field_s (a
/// displacement of all vertices), left_out_at_phases as moving_reduced.modal, and of the state what
/// engine.replay says. `catch_stop` is called once the modes are there; what it returns ends the steps when
/// it turns non-zero ("interrupted"), the option stop_after_s ends them by the clock ("timed_out"); one is
/// taken in any case. Throws:
/// InputError for a body that is not held in every phase, and as ModalPhase.
Response run_modal_replay(const Request& request,
                          const std::function<const volatile std::sig_atomic_t*()>& catch_stop = {});

}  // namespace palpate::reference

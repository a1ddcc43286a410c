// What the methods of the contest `engine` answer (reference/engine/contestant.yaml).
#pragma once

#include <csignal>

#include "reference/door/adapter.h"

namespace palpate::reference {

/// Runs engine.replay, engine.rest, engine.ticks or engine.model on the body `problem`
/// (palpate/moving_body/1) with the mesh `input` (in metres), and writes what belongs to the motion as JSON
/// to `output`:
///
///   {"schema": "palpate/engine/1", "kind": "replay", "columns": [...], "rows": [[...]],
///    "frames": [{"time_s": 0.1, "displacement_m": [x, y, z, x, ...]}]}
///
/// with the history's columns (kind "replay"), the rates (kind "rest"), or times and forces of some ticks,
/// with the forces of the last tenth of them all in "held_forces_n" (kind "ticks"); engine.model writes a
/// model file (reference/engine/model_file.h). The same request gives the same bytes there; times are in the
/// report alone. With a folder in the request, engine.replay writes history.csv and its frames as
/// ParaView's files to it, as they come, and no frames elsewhere.
///
/// The report's outcome is that of the motion: "completed", "inverted", "unsolved", "diverged", "timed_out"
/// (option stop_after_s), "interrupted" (`stop_flag` turned non-zero) or "set_up" (option setup_only).
/// Throws: InputError for a body that cannot be set up, or that engine.ticks cannot step.
Response answer_engine_request(const Request& request, const volatile std::sig_atomic_t* stop_flag = nullptr);

}  // namespace palpate::reference

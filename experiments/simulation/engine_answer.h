// What the methods of the contest `engine` answer (reference/engine/contestant.yaml).
#pragma once

#include "reference/door/adapter.h"

namespace palpate::experiments {

/// Runs engine.replay, engine.rest or engine.ticks on the scene `problem` with the mesh `input` (in metres),
/// and writes what belongs to the motion as JSON (palpate/engine/1) to `output`:
///
///   {"schema": "palpate/engine/1", "columns": [...], "rows": [[...]],
///    "frames": [{"time_s": 0.1, "displacement_m": [x, y, z, x, ...]}]}
///
/// with the history's columns (engine.replay), the rates (engine.rest), or times and forces of some ticks
/// (engine.ticks). The same request gives the same bytes there; times are in the report alone.
///
/// The report's outcome is that of the motion: "completed", "inverted" or "diverged". Throws: InputError for
/// a scene that is not dynamic or cannot be set up, or that engine.ticks cannot step.
reference::Response answer_engine_request(const reference::Request& request);

}  // namespace palpate::experiments

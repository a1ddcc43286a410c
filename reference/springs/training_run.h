// Springs, and moduli where there is a volume model, trained on fields of quadratic elements.
#pragma once

#include "reference/door/adapter.h"

namespace palpate::reference {

/// A request of the contest training: "method" is the one that gives the springs to start from, "options" has
/// "material", "face_opposite", "calibrate" (all springs to start from times one factor, from the moduli that
/// they have on their own mesh), "volume" ("none", "tet" or "node_average"), "ridges", "iterations" of each
/// fit, "splits" (read_training_split: train, validate, test_loads, test_clamps) and, with a volume model,
/// "moduli_out".
///
/// Fits with each ridge; the validation set alone chooses, among the start and the fits, and the test sets
/// are solved once, at the end. Beside the trained constants stand those to start from, the start method with
/// face-opposite springs calibrated on its own mesh, and linear elements. Leaves the springs' CSV, and the
/// moduli's, one row a vertex or tet.
///
/// The report has counts, the ridges with their errors, and for each set and model the root mean square and
/// the worst of the relative L2 errors over the volume, with every case. What it does it says on standard
/// output, one JSON object a line: {"note": LINE}, {"fits": COUNT}, {"now": LINE}, {"said": LINE}, {"left_s":
/// SECONDS} after each fit.
Response run_training(const Request& request);

}  // namespace palpate::reference

// What a plan of the contest stability may set of a body, beside the options of its contestants.
#pragma once

#include <vector>

#include "experiments/registry/option_spec.h"

namespace palpate::experiments {

/// Mesh, material, factors, damping, hold and start. Every method of the contest has them among its options,
/// so that plans set and sweep them like these; the runner makes the body of them (mesh_in and problem_in of
/// a request), and a contestant never sees them.
const std::vector<OptionSpec>& stability_settings();

}  // namespace palpate::experiments

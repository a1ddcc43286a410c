// moving_lattice.*: a request of the contest motion.
#pragma once

#include "reference/door/adapter.h"

namespace palpate::reference {

/// Answers a request of moving_lattice.hexahedral and moving_lattice.bcc: the cells' masses lumped at the
/// nodes, Rayleigh's damping, symplectic Euler at a step below the predicted bound of every phase.
///
/// The report holds outcome ("completed", "diverged"), integrator, time_step_s, stable_step_s, steps,
/// identify_s, setup_s, solve_s and the frequencies that are asked for. Throws: InputError for a bad request,
/// large strain, or a time step over the predicted bound.
Response run_moving_lattice(const Request& request);

}  // namespace palpate::reference

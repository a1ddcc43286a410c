// Natural frequencies of a held body.
#pragma once

#include <vector>

#include "reference/fenicsx/motion/moving_body.h"

namespace palpate::reference::fenicsx {

/// The lowest `count` natural frequencies in Hz, rising, without damping, of the body with the supports and
/// clamps that are there in the last phase: K x = omega^2 M x, held entries left out. Rigid motions come
/// first, at zero. Krylov-Schur iterations on (K - s M)^-1 M with MUMPS, s below zero, so that a body may be
/// free; residuals at most 1e-9. Source: SLEPc.
///
/// Throws: InputError for large strain or more frequencies than the body has; std::runtime_error if the
/// iteration does not converge.
std::vector<double> find_frequencies(const TetMesh& mesh, const MotionProblem& problem, ElasticBody& body,
                                     std::size_t count);

}  // namespace palpate::reference::fenicsx

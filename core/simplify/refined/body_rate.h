// How fast a body of linear elements swings at most: what the longest stable step of explicit schemes is.
#pragma once

#include <optional>

#include "core/mesh/tet_mesh.h"

namespace palpate::simplify {

/// The largest eigenvalue of M^-1 K / mu, K the stiffness of the mesh as linear elements at Poisson's ratio
/// 0.3 and M its lumped mass for density 1, in 1 / length^2: the square of the body's greatest frequency is
/// that times mu / rho, and no VertexRate is above it. By Spectra's restarted Lanczos method, to a thousandth
/// of it; nothing should that not converge within `most_restarts`. 0 without tets. Requires: positive tets.
///
/// Memory: 13 numbers a tet and 80 a vertex, while it runs.
std::optional<double> greatest_rate_of_body(const TetMesh& mesh, int most_restarts = 100);

/// Whether `a` swings slower than `b`: by their greatest rates, or where one of these is not to be had by the
/// greatest VertexRate of both.
bool swings_slower(const TetMesh& a, const TetMesh& b);

}  // namespace palpate::simplify

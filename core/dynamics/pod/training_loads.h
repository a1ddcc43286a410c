// Loads to train a reduced body on, drawn around one that it will be asked for.
#pragma once

#include <cstdint>

#include "core/base/random.h"
#include "core/mesh/boundary_problem.h"

namespace palpate::dynamics {

/// The problem with every load (pads and supports that are moved, tractions, pressures, forces on vertices,
/// weight) times one random share and turned by one random rotation: the share even in [0.2, 1.2], the angle
/// even up to 45 degrees about an axis even on the sphere. Places, supports and held faces stay as they are.
///
/// So the place of a load is known in training, its size and direction are not. Throws: InputError for a
/// problem without a load, or with one that varies or moves held faces.
BoundaryProblem draw_training_load(const BoundaryProblem& problem, SplitMix64& random);

/// FNV-1a (64 bits) of where a problem loads its body, without how strongly: faces and weights of tractions,
/// which of them press, the vertices of forces, which supports are moved, and whether there is weight. Loads
/// of one training have one; what is held and supported is none of it.
std::uint64_t hash_load_places(const BoundaryProblem& problem);

}  // namespace palpate::dynamics

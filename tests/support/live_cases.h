// A small organ under a finger for the tests of live: mesh, supports, springs.
#pragma once

#include "live/body/live_body.h"

namespace palpate::testing_support {

/// A jittered Kuhn cube of 60 mm with springs of van Gelder's kind, E = 10 kPa, nu = 0.45, on elastic
/// supports under z = 0, damped by mass.
live::BodySetup make_live_cube(int cells_per_side);

/// The vertex of the skin nearest to the middle of the cube's top.
Index top_vertex(const TetMesh& mesh);

/// Linear tets at small strain.
live::ModelChoice linear_tets();

}  // namespace palpate::testing_support

// Another skin of the same body, by a seed.
#pragma once

#include <cstdint>

#include "core/mesh/tet_mesh.h"

namespace palpate::experiments {

/// Moves each vertex along the skin, at random, by up to a tenth of its shortest edge: another skin of the
/// same body, and so another mesh of it. Seed 0 leaves the skin as it is.
///
/// A move is in the plane that stands on the sum of the area vectors around the vertex, so it leaves a smooth
/// body by (distance)^2 / (2 radius). One that would turn a triangle around by more than 60 degrees is not
/// made. The same seed gives the same bits.
void jitter_skin(std::uint64_t seed, SurfaceMesh& skin);

}  // namespace palpate::experiments

// Bodies drawn at random for the fuzzing of operations: with handles and cavities, fine skins, thin and flat
// tets. None of them comes from a mesher.
#pragma once

#include <cstdint>
#include <string>

#include "core/base/random.h"
#include "core/mesh/tet_mesh.h"

namespace palpate::testing_support {

/// A body and what it is.
struct RandomBody {
  std::string name;
  TetMesh mesh;
};

/// Unit cells of a plate of up to 6 x 5, or of a block of up to 4 x 4 x 3, with some taken out, as long as
/// what is left is one manifold: handles and cavities come and go. Inner vertices are shaken.
TetMesh make_random_cells(SplitMix64& random);

/// The tets between shrinking copies of a closed skin around the origin, which every ray from there meets
/// once: a skin as fine as wanted over an inside that is not. `layers` >= 1 shells, each `shrink` of the one
/// before; filled by a cone from the origin, or hollow.
TetMesh make_shells(const SurfaceMesh& skin, int layers, double shrink, bool is_hollow);

/// One of some hundreds to some thousand tets, valid; the same for the same seed.
RandomBody make_random_body(std::uint64_t seed);

}  // namespace palpate::testing_support

// What every operation on a working mesh has to keep, as the judge sees it.
#pragma once

#include "core/mesh/tet_mesh.h"
#include "core/simplify/tet_operations/working_mesh.h"

namespace palpate::testing_support {

/// The alive tets of a working mesh as a plain mesh; the working mesh stays as it is.
TetMesh copy_of(const simplify::WorkingMesh& mesh);

/// Expects that stars, flags and counts of the working mesh agree with its tets.
void expect_consistent(const simplify::WorkingMesh& mesh);

/// Expects a mesh that the judge finds valid, with the boundary of `input`, to the bit.
void expect_valid_with_boundary_of(const TetMesh& mesh, const TetMesh& input);

/// A cube of cells^3 Kuhn cells whose inner vertices lie near some of their neighbours: slivers and needles.
TetMesh make_sliver_cube(int cells, std::uint64_t seed);

}  // namespace palpate::testing_support

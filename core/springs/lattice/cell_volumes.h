// How much of each cell of a cubic grid a body fills.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "core/mesh/tet_mesh.h"

namespace palpate::springs {

/// Volume of the body in each cell [i, i + 1] x [j, j + 1] x [k, k + 1], exact but for rounding: each tet is
/// cut at the planes between the cells into tets that lie in one of them.
///
/// Shape:    `body` in units of the cells' side; one entry a cell, i + size[0] (j + size[1] k).
/// Requires: points within [0, size]; what rounding puts beyond counts for the outermost cell.
std::vector<double> measure_cell_volumes(const TetMesh& body, const std::array<int, 3>& size);

}  // namespace palpate::springs

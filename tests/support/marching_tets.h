// Bodies as scanners' surfaces make them: a grid of tets cut where a function changes its sign.
#pragma once

#include <functional>

#include "core/mesh/tet_mesh.h"

namespace palpate::testing_support {

/// The part of `grid` in which `level`, linear on each tet between its values at the vertices, is positive
/// (marching tetrahedra). The skin crosses edges wherever that happens to be, also next to their ends: it has
/// needles, and tets that are all but flat at them. A prism is divided by the diagonals from the least number
/// of each of its quadrilaterals (Dompierre and others 1999), so that neighbours fit.
TetMesh cut_by_level(const TetMesh& grid, const std::function<double(const Vec3&)>& level);

/// A ring of genus 1, its axis askew, cut out of a block of 4 n x 4 n x 2 n cells in [-1, 1]^2 x [-1/2, 1/2].
TetMesh make_marching_ring(int n);

}  // namespace palpate::testing_support

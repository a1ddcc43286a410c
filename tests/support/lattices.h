// Spring networks on lattices, with their constants in closed form.
#pragma once

#include <array>
#include <vector>

#include "core/base/types.h"
#include "core/mesh/spring_network.h"

namespace palpate::springs {

/// A lattice of points, in m, and its springs.
struct LatticeNetwork {
  std::vector<Vec3> points;
  SpringNetwork network;
};

/// A block of cubic cells of side h.
struct LatticeBlock {
  std::array<int, 3> cells{1, 1, 1};
  double spacing_m = 1.0;
  double young_modulus_pa = 1.0;
};

/// The structured (hexahedral) network: springs on the edges, the face diagonals and the body diagonals of
/// each cell, isotropic with Young's modulus E and Poisson's ratio 1/4 for every `body_share` s in [0, 1]:
///
///   inside: edges k = (0.4 + 0.4 s) E h, face diagonals 0.4 (1 - s) E h, body diagonals 0.3 s E h,
///
/// the solutions of the two conditions that a cubic lattice leaves: sum w (x^4 - 3 x^2 y^2) = 0 and
/// sum w = 12 E h^3 with w = k U^2. Each cell carries its own share (a quarter of an edge, half a face
/// diagonal), so springs on the block's faces and edges are softer. With s = 0 (the default: edges and face
/// diagonals, all of the same k inside, no body diagonals) every vertex, those of the surface too, also
/// balances the stress of a uniform strain: the block passes the patch test.
///
/// Vertex (i, j, l) has the number i + (nx + 1) (j + (ny + 1) l).
/// Throws: InputError for fewer than 1 or more than 200 cells a side, a spacing or modulus that is not
/// positive and finite, a share outside [0, 1].
/// Source: thesis 3.3 names the hexahedral model and gives no constants; these follow from eq. 3.15 and 3.17.
LatticeNetwork build_hexahedral_network(const LatticeBlock& block, double body_share = 0.0);

/// The body-centred cubic network: corners of the cells and their centres; half diagonals of 0.6 E h inside
/// the cells, axes of 0.4 E h between neighbouring centres, and axes along the edges of the cells, to which
/// each cell gives 0.1 E h, so 0.4 E h inside the block. Vertices whose neighbours are all there are
/// isotropic with Poisson's ratio 1/4 and balance uniform stress; the block's surface has no centres beyond
/// it and does not (build_bcc_bar with `isotropy_patch` ends in flat faces that do).
///
/// Corners come first, numbered as above, then centres, numbered likewise without the + 1.
/// Throws: as build_hexahedral_network.
LatticeNetwork build_bcc_network(const LatticeBlock& block);

}  // namespace palpate::springs

// What a lattice is made of: springs in closed form, masses, and the mean dilatation of its cells.
#pragma once

#include <array>
#include <vector>

#include "core/mesh/spring_network.h"
#include "core/springs/lattice/lattice.h"

namespace palpate::springs {

/// Half of an axis that ends in the middle of a cell's face, which moves with the mean of the face's corners:
/// the energy 1/2 k (direction . (u_centre - mean of u_corners))^2.
struct HalfAxis {
  Index centre = 0;
  std::array<Index, 4> corners{};
  Vec3 direction;  ///< of length 1
  double stiffness_n_per_m = 0.0;
};

/// What is free in the constants; each lattice has one of them.
struct LatticeMix {
  double body_share = 0.0;  ///< s, of a hexahedral lattice: of body diagonals in place of face diagonals
  double face_share =
      0.0;  ///< t, of a body-centred one: of edges and face diagonals in place of its own springs
};

/// The springs of a lattice; half_axes are those of a body-centred one at its surface.
struct LatticeSprings {
  SpringNetwork network;
  std::vector<HalfAxis> half_axes;
};

/// The springs of a lattice of spacing h, isotropic with Young's modulus E and Poisson's ratio 1/4.
///
/// A network of springs with w = k l^2 has the moduli C_abcd = sum w e_a e_b e_c e_d / V. Isotropy and nu =
/// 1/4 ask for C_xxxx = 3 C_xxyy = 1.2 E; by the cube's symmetry there is nothing else. Per cell, V = h^3,
/// with the weights of edges, face diagonals and body diagonals (3, 6 and 4 of them a cell):
///
///   hexahedral  w_e + w_f + 4/9 w_b = 1.2 E h^3,  w_f / 2 + 4/9 w_b = 0.4 E h^3. With the free share s:
///               k_e = 0.4 (1 + s) E h,  k_f = 0.4 (1 - s) E h,  k_b = 0.3 s E h
///   bcc         8 half diagonals and 2 x 3 axes: k = 0.6 E h and 0.4 E h; with the free share t each cell is
///   1 - t of
///               that and t of a hexahedral one with s = 0, which is as isotropic
///
/// With s = 1 nothing resists waves that turn each neighbour over, (pi, pi, 0) / h: refused.
///
/// Each cell gives its Lattice::share of what it has part in: a quarter of each edge, half of each face
/// diagonal, all of its body or half diagonals. The axis between two centres has 0.4 E h times the smaller
/// share of both; what a cell has beyond that (all of it where no cell is next) is a HalfAxis of 0.8 E h. So
/// each cell by itself is isotropic, and a centre is at rest in a uniform strain.
///
/// A hexahedral cell with s = 0 pulls at its corners, in a uniform strain e, exactly as a trilinear element
/// does: a body that whole cells fill passes the patch test. With s > 0, and for bcc (s = 1 in this), the
/// corner (x, y, z), each +-1, is pulled by -0.2 s E h^2 x y z (e_yz, e_zx, e_xy) besides. The cells around
/// an inner node, a node in a face or an edge of a block take that from each other; those at the block's
/// corners do not.
///
/// With t = 0 a body-centred cell that hangs by one face turns about it freely: edges, half diagonals and
/// half axes are not strained by a torsion. Cut bodies have such cells; they want t > 0.
///
/// Throws: InputError for a modulus that is not above zero, `body_share` (s) outside [0, 0.9] or `face_share`
/// (t) outside
///         [0, 0.9].
/// Source: thesis 3.3 names the hexahedral model and gives no constants; M. Kot, H. Nagahashi and P.
/// Szymczak,
///         The Visual Computer 31 (2015), 1339-1350, have those with s = 0 (one k for all springs).
LatticeSprings build_lattice_springs(const Lattice& lattice, double young_modulus_pa,
                                     const LatticeMix& mix = {});

/// Masses in kg: each cell's share x density x volume, an eighth at each corner; a body-centred one's half in
/// the middle and a sixteenth at each corner. Throws: InputError for a density that is not above zero.
std::vector<double> build_lattice_masses(const Lattice& lattice, double density_kg_m3);

/// Gradients, in 1/m, of the corners' shape functions, averaged over a cell: the same for all cells. A node
/// in the middle has none: its function is zero on the cell's faces.
std::array<Vec3, 8> mean_cell_gradients(const Lattice& lattice);

}  // namespace palpate::springs

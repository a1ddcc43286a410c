// Points in the cells of a lattice: a field at the nodes, carried to them, and forces carried back.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/springs/lattice/lattice.h"

namespace palpate::springs {

/// The field at point p is the sum of weights[k] x the field at nodes[k], k from offsets[p] to offsets[p +
/// 1]. The weights of a point add up to 1, and each linear field is reproduced.
struct Embedding {
  std::vector<Index> offsets{0};
  std::vector<Index> nodes;
  std::vector<double> weights;
  std::size_t outside = 0;      ///< points beyond the cells: there the nearest one's functions go on
  double farthest_cells = 0.0;  ///< how far the farthest of them is from its cell, in spacings

  std::size_t points() const { return offsets.size() - 1; }
};

/// Trilinear functions of a cell's corners; a body-centred one adds (u_centre - mean of the corners) t, with
/// the tent t = 1 - 2 max |p_i - 1/2| in the cell and 0 beyond. A point between cells that are there is in
/// the first of the nearest ones. Throws: InputError for a point that is not finite.
Embedding build_embedding(const Lattice& lattice, std::span<const Vec3> points);

/// The field at each point. Shape: one vector a node in, one a point out.
std::vector<Vec3> interpolate(const Embedding& embedding, std::span<const Vec3> at_nodes);

/// Adds each point's force to the nodes, by the same weights: the transpose of interpolate.
void carry_back(const Embedding& embedding, std::span<const Vec3> at_points, std::span<Vec3> at_nodes);

}  // namespace palpate::springs

// Points in an order that keeps neighbours in space near each other in memory.
#pragma once

#include <span>
#include <vector>

#include "core/mesh/tet_mesh.h"

namespace palpate {

/// The numbers of the points along the Morton curve through their bounding box, at 2^21 cells a side; points
/// of one cell by number. Any number of threads gives the same.
std::vector<Index> order_in_space(std::span<const Vec3> points, int threads = 1);

/// Where a mesh that was brought into another order comes from: the input's numbers of its vertices and tets.
struct MeshOrigin {
  std::vector<Index> vertices;
  std::vector<Index> tets;
};

/// Renumbers a mesh so that what is near in space is near in memory: vertices along the curve, tets by their
/// smallest vertex. Any number of threads gives the same.
MeshOrigin sort_in_space(TetMesh& mesh, int threads = 1);

}  // namespace palpate

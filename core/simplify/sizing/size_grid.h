// Wanted sizes that were given at the vertices of a mesh, as a field over space.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "core/mesh/tet_mesh.h"

namespace palpate::simplify {

/// The wanted edge length over the greatest that is wanted anywhere, on a regular grid over the box of a
/// mesh, trilinear in between.
///
/// A node inside a tet has the value that is linear between its corners; one outside the mesh that of the
/// nearest nodes that have one, layer by layer. Cells are 0.75 times as wide as a vertex has room, so the
/// field is within the change over a cell's diagonal of the values given. A place outside the box is taken
/// for the nearest in it. Holds no reference to the mesh. Safe to ask from several threads.
class SizeGrid {
 public:
  /// One size a vertex, in any unit. Throws: InputError unless there is one for each, all finite and above 0,
  /// none more than 1000 times another.
  SizeGrid(const TetMesh& mesh, std::span<const double> sizes);

  /// In (0, 1]. A few operations.
  double at(const Vec3& x) const;

  /// The least value of a node.
  double least() const { return least_; }

 private:
  std::size_t index(std::size_t i, std::size_t j, std::size_t k) const {
    return (k * nodes_[1] + j) * nodes_[0] + i;
  }
  void lay_out(const TetMesh& mesh);
  void fill_tet(const TetMesh& mesh, const Tet& tet, std::span<const double> relative);
  void fill_at_vertices(const TetMesh& mesh, std::span<const double> relative);
  void fill_outside();

  Vec3 low_;
  double cell_ = 1.0;
  std::array<std::size_t, 3> nodes_{2, 2, 2};
  std::vector<float> value_;  ///< 0 until it is known
  double least_ = 1.0;
};

/// The grid of sizes, one a vertex; nothing where all are equal, which is no field at all.
/// Throws: InputError as SizeGrid.
std::shared_ptr<const SizeGrid> make_size_grid(const TetMesh& mesh, std::span<const double> sizes);

}  // namespace palpate::simplify

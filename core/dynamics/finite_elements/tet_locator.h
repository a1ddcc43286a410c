// Where a point lies in a mesh, and a field of elements there.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "core/dynamics/finite_elements/elements.h"
#include "core/mesh/tet_mesh.h"

namespace palpate::dynamics {

/// A tet and the barycentric coordinates of a point in it; their sum is 1.
struct TetPlace {
  std::size_t tet = 0;
  std::array<double, 4> at{};
};

/// Finds the tet of a point, over a grid of boxes.
class TetLocator {
 public:
  /// `mesh` must outlive it. Requires: tets of positive volume.
  explicit TetLocator(const TetMesh& mesh);

  /// The first tet that holds the point; of a point outside, by no more than rounding, the one that it lies
  /// least outside of. Throws: InputError for a point that is more than 1e-6 of a tet's height outside.
  TetPlace find(const Vec3& point) const;

 private:
  std::size_t cell_of(const Vec3& point, std::size_t axis) const;
  std::size_t number_of(std::size_t i, std::size_t j, std::size_t k) const;

  const TetMesh& mesh_;
  Vec3 low_;
  double cell_ = 1.0;  ///< side of a cell
  std::array<std::size_t, 3> count_{1, 1, 1};
  std::vector<std::size_t> offsets_;
  std::vector<Index> tets_;
};

/// A field with one value a node of the space, at a place of the space's mesh: exact for its shape functions.
Vec3 evaluate(const ElementSpace& space, std::span<const Vec3> field, const TetPlace& place);

}  // namespace palpate::dynamics

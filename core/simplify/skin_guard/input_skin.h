// The skin that a mesh came with: what GuardedBoundary holds later skins to.
#pragma once

#include <array>
#include <vector>

#include "core/simplify/cover/cover_check.h"
#include "core/simplify/sizing/triangle_tree.h"
#include "core/simplify/tet_operations/working_mesh.h"

namespace palpate::simplify {

/// Triangles that stay, by number, by place and by neighbourhood.
class InputSkin {
 public:
  /// `faces`: of a closed oriented surface. Throws: InputError if there is none.
  InputSkin(const WorkingMesh& mesh, const std::vector<Triangle>& faces);

  std::size_t size() const { return faces_.size(); }
  const Triangle& face(Index i) const { return faces_[i]; }
  const BoxedTriangle& triangle(Index i) const { return triangles_[i]; }
  /// The triangles across the edges of i; kNoIndex where there is none.
  const std::array<Index, 3>& neighbours(Index i) const { return neighbours_[i]; }
  const TriangleTree& tree() const { return tree_; }
  double mean_edge() const;

 private:
  std::vector<Triangle> faces_;
  std::vector<BoxedTriangle> triangles_;
  std::vector<std::array<Index, 3>> neighbours_;
  TriangleTree tree_;
};

}  // namespace palpate::simplify

// A tree of boxes over the tets of a mesh: which tet holds a point.
#pragma once

#include <array>
#include <limits>
#include <vector>

#include "core/judge/surface/triangle_tree.h"
#include "core/mesh/tet_mesh.h"

namespace palpate::judge {

/// A tet and the barycentric coordinates of a point in it; their sum is 1.
struct TetPlace {
  Index tet = kNoIndex;
  std::array<double, 4> share{};
  double least = -std::numeric_limits<double>::infinity();  ///< of the four: negative outside
};

/// Binary tree of boxes, halved at the median of the centroids along the longest side. It refers to the mesh,
/// which has to outlive it.
class TetTree {
 public:
  /// Requires valid indices and finite points.
  explicit TetTree(const TetMesh& mesh);

  /// The tet that holds p: of those whose box holds it the first whose coordinates are all >= 0; if there is
  /// none, the one whose least coordinate is greatest. Tets of volume zero hold nothing.
  TetPlace find(const Vec3& p) const;

 private:
  struct Node {
    Box box;
    Index first = 0;  ///< child, the other one follows; or the leaf's first tet
    Index count = 0;  ///< of the leaf's tets; 0 for an inner node
  };

  void build(Index node, Index begin, Index end, const std::vector<Vec3>& centers);

  const TetMesh& mesh_;
  std::vector<Node> nodes_;
  std::vector<Index> number_;  // tets in the order of the leaves
};

}  // namespace palpate::judge

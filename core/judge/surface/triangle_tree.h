// A tree of boxes over triangles: nearest triangle, and triangles near a box.
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "core/base/types.h"

namespace palpate::judge {

/// The corners of a triangle.
struct Corners {
  Vec3 a;
  Vec3 b;
  Vec3 c;
};

/// A box along the axes.
struct Box {
  Vec3 low{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(),
           std::numeric_limits<double>::infinity()};
  Vec3 high{-std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity(),
            -std::numeric_limits<double>::infinity()};

  void add(const Vec3& p);
  void add(const Corners& t);
  bool meets(const Box& other) const {
    return low.x <= other.high.x && other.low.x <= high.x && low.y <= other.high.y && other.low.y <= high.y &&
           low.z <= other.high.z && other.low.z <= high.z;
  }
  /// Squared distance from p; 0 inside.
  double distance_sq(const Vec3& p) const;
  /// The axis of the longest side; of equally long ones the first.
  std::size_t longest_axis() const {
    const Vec3 size = high - low;
    if (size.x >= size.y && size.x >= size.z) return 0;
    return size.y >= size.z ? 1 : 2;
  }
};

/// Squared distance from a point to a closed triangle; one without area is its sides.
double distance_sq(const Vec3& p, const Corners& t);

/// A triangle by its place in the list that the tree was built from, and its squared distance.
struct Nearest {
  Index triangle = kNoIndex;
  double distance_sq = std::numeric_limits<double>::infinity();
};

/// Binary tree of boxes, halved at the median along the longest side.
class TriangleTree {
 public:
  explicit TriangleTree(std::span<const Corners> triangles);

  const Corners& triangle(Index i) const { return triangles_[place_[i]]; }

  /// The triangle nearest to p. `hint` is one that may be near, or kNoIndex. Requires at least one triangle.
  Nearest nearest(const Vec3& p, Index hint = kNoIndex) const;

  /// Calls visit(i) for each triangle i whose box meets `box` (touching counts).
  template <typename Visit>
  void for_each_near(const Box& box, Visit&& visit) const {
    if (nodes_.empty()) return;
    std::array<Index, kStackSize> stack{};
    std::size_t size = 1;
    while (size > 0) {
      const Node& node = nodes_[stack[--size]];
      if (!node.box.meets(box)) continue;
      if (node.count == 0) {
        stack[size++] = node.first;
        stack[size++] = node.first + 1;
        continue;
      }
      for (Index k = node.first; k < node.first + node.count; ++k) {
        if (boxes_[k].meets(box)) visit(number_[k]);
      }
    }
  }

 private:
  /// One node waits for each of the at most 32 levels, and the last level has two.
  static constexpr std::size_t kStackSize = 64;

  struct Node {
    Box box;
    Index first = 0;  ///< child, the other one follows; or the leaf's first triangle
    Index count = 0;  ///< of the leaf's triangles; 0 for an inner node
  };

  void build(Index node, Index begin, Index end);

  std::vector<Node> nodes_;
  std::vector<Corners> triangles_;  // in the order of the leaves
  std::vector<Box> boxes_;
  std::vector<Index> number_;  // by place: which triangle of the list
  std::vector<Index> place_;   // the other way round
};

}  // namespace palpate::judge

// The distance to a set of triangles, by a tree of axis-parallel boxes.
#pragma once

#include <algorithm>
#include <array>
#include <limits>
#include <span>
#include <vector>

#include "core/mesh/geometry.h"

namespace palpate::simplify {

/// Squared distance from p to the segment from a to b; exactly 0 at its ends. A segment may be a point.
double distance_sq_to_segment(const Vec3& p, const Vec3& a, const Vec3& b);

/// Squared distance from p to triangle (a, b, c); exactly 0 at its corners. It may be flat or a point.
double distance_sq_to_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c);

/// Squared distance from p to a box.
inline double distance_sq_to_box(const Vec3& p, const BoundingBox& box) {
  const auto gap = [](double x, double low, double high) { return std::max({low - x, x - high, 0.0}); };
  return length_sq(Vec3{gap(p.x, box.low.x, box.high.x), gap(p.y, box.low.y, box.high.y),
                        gap(p.z, box.low.z, box.high.z)});
}

/// Whether two boxes have a point in common.
inline bool do_overlap(const BoundingBox& a, const BoundingBox& b) {
  return a.low.x <= b.high.x && b.low.x <= a.high.x && a.low.y <= b.high.y && b.low.y <= a.high.y &&
         a.low.z <= b.high.z && b.low.z <= a.high.z;
}

/// Makes a box so large that it holds another one too.
inline void extend(BoundingBox& box, const BoundingBox& by) {
  box.low = {std::min(box.low.x, by.low.x), std::min(box.low.y, by.low.y), std::min(box.low.z, by.low.z)};
  box.high = {std::max(box.high.x, by.high.x), std::max(box.high.y, by.high.y),
              std::max(box.high.z, by.high.z)};
}

/// Squared distance between two boxes.
inline double distance_sq_of_boxes(const BoundingBox& a, const BoundingBox& b) {
  const auto gap = [](double low_a, double high_a, double low_b, double high_b) {
    return std::max({low_a - high_b, low_b - high_a, 0.0});
  };
  return length_sq(Vec3{gap(a.low.x, a.high.x, b.low.x, b.high.x), gap(a.low.y, a.high.y, b.low.y, b.high.y),
                        gap(a.low.z, a.high.z, b.low.z, b.high.z)});
}

/// Squared distance between two segments that do not cross.
double distance_sq_of_segments(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

/// Squared distance between a tet and a triangle that have no inner point in common (they may touch).
double distance_sq_of_tet_and_triangle(const std::array<Vec3, 4>& tet, const std::array<Vec3, 3>& triangle);

/// Triangles in a binary tree of bounding boxes, split at the median along the longest axis. Built in
/// O(n log n); a query of a point near n evenly spread triangles visits about log n boxes.
class TriangleTree {
 public:
  /// Throws: InputError if there is no triangle.
  TriangleTree(std::span<const Vec3> points, std::span<const Triangle> triangles);

  /// A triangle nearest to p, and the squared distance.
  struct Nearest {
    const std::array<Vec3, 3>* triangle = nullptr;  ///< none is nearer than the bound: nullptr
    double distance_sq = 0.0;
  };
  Nearest nearest(const Vec3& p, double bound_sq = std::numeric_limits<double>::infinity()) const;

  /// Is the squared distance from p to some triangle below the bound? Ends at the first that is.
  bool is_below(const Vec3& p, double bound_sq) const;

  /// Distance from p to the nearest triangle if that is below `bound`, else `bound`.
  double distance(const Vec3& p, double bound = std::numeric_limits<double>::infinity()) const;

  /// Is the tet, which crosses no triangle, within `reach` of one?
  bool is_within(const std::array<Vec3, 4>& tet, double reach) const;

 private:
  struct Node {
    BoundingBox box;
    std::size_t first = 0;  ///< of the triangles below, in corners_
    std::size_t count = 0;
    std::size_t right = 0;  ///< the second child; the first is the next node. 0: a leaf
  };
  void build(std::size_t first, std::size_t count);
  template <bool kAny>
  Nearest search(const Vec3& p, double bound_sq) const;

  std::vector<std::array<Vec3, 3>> corners_;
  std::vector<Node> nodes_;
};

}  // namespace palpate::simplify

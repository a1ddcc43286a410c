// Is every point of a triangle within a distance of other triangles? A decision with a proof: never "yes" for
// a triangle that is not.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "core/base/types.h"
#include "core/simplify/sizing/triangle_tree.h"

namespace palpate::simplify {

/// The corners of a triangle.
using TriangleCorners = std::array<Vec3, 3>;

/// A triangle with what says quickly that a point is far from it: the box around it and its plane.
struct BoxedTriangle {
  TriangleCorners corner;
  BoundingBox box;
  Vec3 normal;             ///< of any length
  double normal_sq = 0.0;  ///< its square; 0 for a triangle that is so flat that its plane says nothing

  explicit BoxedTriangle(const TriangleCorners& t);
};

/// Boxes and planes are apart by no more than what is in them, but for rounding.
inline constexpr double kBoxSlack = 1.0 - 1e-12;

/// Whether something in one box may be within a distance of something in another, `limit_sq` its square.
inline bool may_be_within(double limit_sq, const BoundingBox& a, const BoundingBox& b) {
  return kBoxSlack * distance_sq_of_boxes(a, b) <= limit_sq;
}

/// Answers one such question after another.
///
/// A convex piece P whose corners are all within the limit of one triangle b lies within the limit of b,
/// since the distance to a convex set is convex. Where no b does it alone, P is cut along the planes that
/// stand on the sides of the b nearest to the middle of P, or halved. A middle beyond the limit is a definite
/// no; too many pieces are a no as well, which may be wrong, on the safe side.
class CoverTest {
 public:
  explicit CoverTest(double limit) : limit_sq_(limit * limit) {}

  double limit_sq() const { return limit_sq_; }
  double limit() const { return std::sqrt(limit_sq_); }

  /// Every point of `triangle` within the limit of some triangle of `by`?
  bool is_covered(const TriangleCorners& triangle, const TriangleTree& by);
  /// The same where the corners are known to be.
  bool is_inside_covered(const TriangleCorners& triangle, const TriangleTree& by);

  /// The same for a short list. `used` gets the numbers of the triangles that are enough; it is cleared
  /// first.
  bool is_covered(const BoxedTriangle& triangle, std::span<const BoxedTriangle> by, std::vector<Index>& used);

  /// Where the last answer was yes: no point of the triangle is farther than this from those.
  double reach() const { return std::min(std::sqrt(reach_sq_) * (1.0 + 1e-12), limit()); }

  /// Is the point within the limit of some triangle? Cheap, and necessary wherever it is a point of what is
  /// to be covered.
  bool is_near(const Vec3& p, const TriangleTree& by) const;
  bool is_near(const Vec3& p, std::span<const BoxedTriangle> by) const;

 private:
  static constexpr std::size_t kMostCorners = 12;
  struct Piece {
    std::array<Vec3, kMostCorners> corner;
    std::size_t size = 0;
    const TriangleCorners* cut_along = nullptr;  ///< cutting along it again would gain nothing

    void add(const Vec3& p) { corner[size++] = p; }
  };

  template <typename FindNearest, typename Use>
  bool run(const TriangleCorners& triangle, std::size_t most_pieces, const FindNearest& find_nearest,
           const Use& use);
  bool is_within(const Piece& piece, const TriangleCorners& b);
  /// Just above the limit, so that a distance of exactly the limit is found.
  double bound_sq() const { return limit_sq_ * (1.0 + 1e-15) + 1e-300; }
  bool push(const Piece& piece);
  bool cut_along(const Piece& piece, const TriangleCorners& b);
  bool halve(const Piece& piece, const Vec3& middle);

  double limit_sq_ = 0.0;
  double reach_sq_ = 0.0;
  std::vector<Piece> open_;
  Index hint_ = kNoIndex;                   ///< in a short list: what was of use last is near again, mostly
  std::vector<const BoxedTriangle*> near_;  ///< of a short list, those that are not too far by their boxes
};

}  // namespace palpate::simplify

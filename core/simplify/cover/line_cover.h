// Is every point of a segment within a distance of other segments? A decision with a proof: never "yes" for a
// segment that is not. The counterpart of CoverTest for curves.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "core/base/types.h"
#include "core/simplify/sizing/triangle_tree.h"

namespace palpate::simplify {

/// The ends of a segment.
using SegmentEnds = std::array<Vec3, 2>;

/// Answers one such question after another.
///
/// A part P of the segment whose ends are both within the limit of one segment b lies within the limit of b,
/// since the distance to a convex set is convex. Where no b does it alone, P is cut by the planes that stand
/// across the b nearest to the middle of P, at its ends, or halved. A middle beyond the limit is a definite
/// no; too many parts are a no as well, which may be wrong, on the safe side.
class LineCover {
 public:
  explicit LineCover(double limit) : limit_sq_(limit * limit) {}

  double limit_sq() const { return limit_sq_; }

  /// Every point of `segment` within the limit of some segment of `by`, a tree of triangles (a, b, b)?
  bool is_covered(const SegmentEnds& segment, const TriangleTree& by);

  /// The same for a short list. `used` gets the numbers of the segments that are enough; it is cleared first.
  bool is_covered(const SegmentEnds& segment, std::span<const SegmentEnds> by, std::vector<Index>& used);

 private:
  struct Part {
    SegmentEnds ends;
    const Vec3* cut_across = nullptr;  ///< first end of a segment: cutting there again would gain nothing
  };

  template <typename FindNearest, typename Use>
  bool run(const SegmentEnds& segment, const FindNearest& find_nearest, const Use& use);
  bool cut_at_ends(const SegmentEnds& part, const Vec3* b);

  double limit_sq_ = 0.0;
  std::vector<Part> open_;
};

}  // namespace palpate::simplify

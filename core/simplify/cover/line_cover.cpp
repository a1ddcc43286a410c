#include "core/simplify/cover/line_cover.h"

#include <algorithm>
#include <utility>

namespace palpate::simplify {
namespace {

constexpr std::size_t kMostParts = 200;

/// Relative to a part's extent along a segment: nearer than this to one of its ends is at the plane there.
constexpr double kAtPlane = 1e-8;

}  // namespace

/// Cuts a part where the feet of its points on b = (b[0], b[1]) come to the ends of b. Returns false, with
/// nothing pushed, if that is nowhere.
bool LineCover::cut_at_ends(const SegmentEnds& part, const Vec3* b) {
  const Vec3 along = b[1] - b[0];
  std::array<double, 2> cuts{};
  std::size_t count = 0;
  for (const Vec3& end : {b[0], b[1]}) {
    const double here = dot(part[0] - end, along);
    const double there = dot(part[1] - end, along);
    if ((here < 0.0) == (there < 0.0)) continue;
    const double at = here / (here - there);
    if (at > kAtPlane && at < 1.0 - kAtPlane) cuts[count++] = at;
  }
  if (count == 0) return false;
  if (count == 2 && cuts[1] < cuts[0]) std::swap(cuts[0], cuts[1]);
  Vec3 from = part[0];
  for (std::size_t k = 0; k < count; ++k) {
    const Vec3 to = part[0] + cuts[k] * (part[1] - part[0]);
    open_.push_back({{from, to}, b});
    from = to;
  }
  open_.push_back({{from, part[1]}, b});
  return true;
}

template <typename FindNearest, typename Use>
bool LineCover::run(const SegmentEnds& segment, const FindNearest& find_nearest, const Use& use) {
  open_.assign(1, {segment});
  for (std::size_t parts = 0; !open_.empty(); ++parts) {
    if (parts == kMostParts) return false;
    const Part part = open_.back();
    open_.pop_back();
    const Vec3 middle = 0.5 * (part.ends[0] + part.ends[1]);
    const Vec3* b = find_nearest(middle);
    if (b == nullptr) return false;
    if (std::all_of(part.ends.begin(), part.ends.end(),
                    [&](const Vec3& p) { return distance_sq_to_segment(p, b[0], b[1]) <= limit_sq_; })) {
      use(b);
      continue;
    }
    if (part.cut_across != b && cut_at_ends(part.ends, b)) continue;
    open_.push_back({{part.ends[0], middle}});
    open_.push_back({{middle, part.ends[1]}});
  }
  return true;
}

bool LineCover::is_covered(const SegmentEnds& segment, const TriangleTree& by) {
  // Just above the limit, so that a distance of exactly the limit is found.
  const double bound_sq = limit_sq_ * (1.0 + 1e-15) + 1e-300;
  const auto nearest = [&](const Vec3& p) -> const Vec3* {
    const std::array<Vec3, 3>* found = by.nearest(p, bound_sq).triangle;
    return found == nullptr ? nullptr : found->data();
  };
  return run(segment, nearest, [](const Vec3* /*b*/) {});
}

bool LineCover::is_covered(const SegmentEnds& segment, std::span<const SegmentEnds> by,
                           std::vector<Index>& used) {
  used.clear();
  const auto nearest = [&](const Vec3& p) {
    const Vec3* best = nullptr;
    double least = limit_sq_;
    for (const SegmentEnds& b : by) {
      const double here = distance_sq_to_segment(p, b[0], b[1]);
      if (here > least || (best != nullptr && here == least)) continue;
      least = here;
      best = b.data();
    }
    return best;
  };
  const auto remember = [&](const Vec3* b) {
    const auto is_it = [&](const SegmentEnds& one) { return one.data() == b; };
    const auto number = static_cast<Index>(std::find_if(by.begin(), by.end(), is_it) - by.begin());
    if (std::find(used.begin(), used.end(), number) == used.end()) used.push_back(number);
  };
  return run(segment, nearest, remember);
}

}  // namespace palpate::simplify

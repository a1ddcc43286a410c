#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/base/error.h"
#include "core/judge/mesh/exact_orientation.h"
#include "core/judge/surface/surface.h"
#include "core/judge/surface/triangle_tree.h"

namespace palpate::judge {
namespace {

using Segment = std::array<Vec3, 2>;

constexpr double kLeast = std::numeric_limits<double>::denorm_min();

/// A point off the plane of three points; the first of them if they lie on one line. A step from it along one
/// of the axes leaves the plane; half the largest coordinate, towards zero, is a step that neither vanishes
/// in rounding nor leaves the range.
Vec3 point_off_plane(const Vec3& a, const Vec3& b, const Vec3& c) {
  double largest = 0.0;
  for (const Vec3& p : {a, b, c}) {
    largest = std::max({largest, std::fabs(p.x), std::fabs(p.y), std::fabs(p.z)});
  }
  const auto moved = [&](double x) { return x - std::copysign(std::max(0.5 * largest, kLeast), x); };
  for (const Vec3& p : {Vec3{moved(a.x), a.y, a.z}, Vec3{a.x, moved(a.y), a.z}, Vec3{a.x, a.y, moved(a.z)}}) {
    if (exact_orientation(a, b, c, p) != 0) return p;
  }
  return a;
}

bool are_collinear(const Vec3& a, const Vec3& b, const Vec3& c) {
  return point_off_plane(a, b, c) == a;
}

/// Whether p, on the line through the segment's ends, is between them.
bool is_between(const Vec3& p, const Segment& s) {
  const auto within = [](double x, double y, double z) { return std::min(y, z) <= x && x <= std::max(y, z); };
  return within(p.x, s[0].x, s[1].x) && within(p.y, s[0].y, s[1].y) && within(p.z, s[0].z, s[1].z);
}

/// Orientations in a plane, told by a point off it.
class PlaneSide {
 public:
  explicit PlaneSide(const Corners& t) : off_(point_off_plane(t.a, t.b, t.c)) {}
  int operator()(const Vec3& a, const Vec3& b, const Vec3& c) const {
    return exact_orientation(a, b, c, off_);
  }

 private:
  Vec3 off_;
};

bool segments_meet(const Segment& s, const Segment& t, const PlaneSide& side) {
  const int s0 = side(t[0], t[1], s[0]);
  const int s1 = side(t[0], t[1], s[1]);
  const int t0 = side(s[0], s[1], t[0]);
  const int t1 = side(s[0], s[1], t[1]);
  if (s0 * s1 < 0 && t0 * t1 < 0) return true;
  return (s0 == 0 && is_between(s[0], t)) || (s1 == 0 && is_between(s[1], t)) ||
         (t0 == 0 && is_between(t[0], s)) || (t1 == 0 && is_between(t[1], s));
}

bool is_in_triangle(const Vec3& p, const Corners& t, const PlaneSide& side) {
  const int a = side(t.a, t.b, p);
  const int b = side(t.b, t.c, p);
  const int c = side(t.c, t.a, p);
  return (a >= 0 && b >= 0 && c >= 0) || (a <= 0 && b <= 0 && c <= 0);
}

bool meets_in_plane(const Segment& s, const Corners& t) {
  const PlaneSide side(t);
  return is_in_triangle(s[0], t, side) || segments_meet(s, {t.a, t.b}, side) ||
         segments_meet(s, {t.b, t.c}, side) || segments_meet(s, {t.c, t.a}, side);
}

/// Whether a segment and a triangle with an area, both closed, have a point in common.
bool meets(const Segment& s, const Corners& t) {
  const int start = exact_orientation(t.a, t.b, t.c, s[0]);
  const int end = exact_orientation(t.a, t.b, t.c, s[1]);
  if (start * end > 0) return false;
  if (start == 0 && end == 0) return meets_in_plane(s, t);
  const int ab = exact_orientation(s[0], s[1], t.a, t.b);
  const int bc = exact_orientation(s[0], s[1], t.b, t.c);
  if (ab * bc < 0) return false;
  const int ca = exact_orientation(s[0], s[1], t.c, t.a);
  return ab * ca >= 0 && bc * ca >= 0;
}

/// Whether the points lie strictly on one side of the triangle's plane.
template <std::size_t N>
bool are_on_one_side(const std::array<Vec3, N>& points, const Corners& t) {
  int sum = 0;
  for (const Vec3& p : points) {
    const int sign = exact_orientation(t.a, t.b, t.c, p);
    if (sign == 0 || sign * sum < 0) return false;
    sum += sign;
  }
  return true;
}

/// The test of two triangles, by what they share.
class PairTest {
 public:
  explicit PairTest(const SurfaceMesh& surface) : surface_(surface) {}

  /// Whether two triangles with an area meet elsewhere than in what they share.
  bool operator()(Triangle s, Triangle t) const {
    switch (gather_shared(s, t)) {
      case 0:
        return apart_meet(corners(s), corners(t));
      case 1:
        return fans_meet(corners(s), corners(t));
      case 2:
        return wings_meet(corners(s), point(t[2]));
      default:
        return true;
    }
  }

 private:
  const Vec3& point(Index v) const { return surface_.points[v]; }
  Corners corners(const Triangle& t) const { return {point(t[0]), point(t[1]), point(t[2])}; }

  /// Swaps the vertices that both have to the front of both. Returns their number.
  static std::size_t gather_shared(Triangle& s, Triangle& t) {
    std::size_t shared = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto found = std::find(t.begin() + static_cast<std::ptrdiff_t>(shared), t.end(), s[i]);
      if (found == t.end()) continue;
      std::swap(*found, t[shared]);
      std::swap(s[i], s[shared]);
      ++shared;
    }
    return shared;
  }

  /// Nothing shared: one of the six sides meets the other triangle.
  static bool apart_meet(const Corners& s, const Corners& t) {
    if (are_on_one_side(std::array{s.a, s.b, s.c}, t) || are_on_one_side(std::array{t.a, t.b, t.c}, s)) {
      return false;
    }
    return meets({s.a, s.b}, t) || meets({s.b, s.c}, t) || meets({s.c, s.a}, t) || meets({t.a, t.b}, s) ||
           meets({t.b, t.c}, s) || meets({t.c, t.a}, s);
  }

  /// One vertex shared, the first: what they have in common reaches from there to the side opposite to it in
  /// one of the two.
  static bool fans_meet(const Corners& s, const Corners& t) {
    if (are_on_one_side(std::array{s.b, s.c}, t) || are_on_one_side(std::array{t.b, t.c}, s)) return false;
    return meets({s.b, s.c}, t) || meets({t.b, t.c}, s);
  }

  /// Two vertices shared, the first two: they overlap if they lie in one plane on one side of the edge.
  static bool wings_meet(const Corners& s, const Vec3& apex) {
    if (exact_orientation(s.a, s.b, s.c, apex) != 0) return false;
    const PlaneSide side(s);
    return side(s.a, s.b, s.c) == side(s.a, s.b, apex);
  }

  const SurfaceMesh& surface_;
};

}  // namespace

std::uint64_t count_self_intersections(const SurfaceMesh& surface) {
  std::vector<Corners> corners;
  corners.reserve(surface.triangles.size());
  for (const Triangle& t : surface.triangles) {
    for (const Index v : t) {
      require(v < surface.points.size() && is_finite(surface.points[v]),
              "self-intersections: a triangle's vertex does not exist or is not finite");
    }
    corners.push_back({surface.points[t[0]], surface.points[t[1]], surface.points[t[2]]});
  }
  std::uint64_t count = 0;
  std::vector<char> has_area(corners.size());
  for (std::size_t i = 0; i < corners.size(); ++i) {
    has_area[i] = are_collinear(corners[i].a, corners[i].b, corners[i].c) ? 0 : 1;
    if (has_area[i] == 0) ++count;
  }
  const TriangleTree tree(corners);
  const PairTest meet(surface);
  for (Index i = 0; i < corners.size() && count < kMostSelfIntersections; ++i) {
    if (has_area[i] == 0) continue;
    Box box;
    box.add(corners[i]);
    tree.for_each_near(box, [&](Index j) {
      if (j > i && has_area[j] != 0 && meet(surface.triangles[i], surface.triangles[j])) ++count;
    });
  }
  return std::min(count, kMostSelfIntersections);
}

}  // namespace palpate::judge

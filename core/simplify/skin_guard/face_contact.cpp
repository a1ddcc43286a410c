#include "core/simplify/skin_guard/face_contact.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/mesh/orientation.h"

namespace palpate::simplify {
namespace {

using Corners = std::array<Vec3, 3>;

/// Orientations within the plane of a triangle, seen from a point off it.
class InPlane {
 public:
  explicit InPlane(const Corners& t) : eye_(t[0]) {
    double step = 0.0;
    for (const Vec3& p : t) step = std::max({step, std::fabs(p.x), std::fabs(p.y), std::fabs(p.z)});
    for (double Vec3::*axis : {&Vec3::x, &Vec3::y, &Vec3::z}) {
      Vec3 eye = t[0];
      eye.*axis += eye.*axis > 0.0 ? -step : step;
      turn_ = orientation(t[0], t[1], t[2], eye);
      eye_ = eye;
      if (turn_ != 0) return;
    }
  }

  bool has_area() const { return turn_ != 0; }
  /// +1 if (a, b, c) turns as the triangle does.
  int operator()(const Vec3& a, const Vec3& b, const Vec3& c) const {
    return turn_ * orientation(a, b, c, eye_);
  }

 private:
  Vec3 eye_;
  int turn_ = 0;
};

/// Whether a segment in the triangle's plane meets it. Two convex sets are apart if a side of one of them
/// parts them.
bool meets_in_plane(const Vec3& u, const Vec3& w, const Corners& t, const InPlane& side) {
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3& a = t[k];
    const Vec3& b = t[(k + 1) % 3];
    if (side(a, b, u) < 0 && side(a, b, w) < 0) return false;
  }
  const int first = side(u, w, t[0]);
  return first == 0 || side(u, w, t[1]) != first || side(u, w, t[2]) != first;
}

bool segment_meets(const Vec3& u, const Vec3& w, const Corners& t) {
  const int above_u = orientation(t[0], t[1], t[2], u);
  const int above_w = orientation(t[0], t[1], t[2], w);
  if (above_u == 0 && above_w == 0) {
    const InPlane side(t);
    return !side.has_area() || meets_in_plane(u, w, t, side);
  }
  if (above_u * above_w > 0) return false;
  int least = 1;
  int greatest = -1;
  for (std::size_t k = 0; k < 3; ++k) {
    const int turn = orientation(u, w, t[k], t[(k + 1) % 3]);
    least = std::min(least, turn);
    greatest = std::max(greatest, turn);
  }
  return least >= 0 || greatest <= 0;
}

/// Whether corners first .. 2 of `a` are all strictly on one side of the plane of `b`.
bool is_beside(const Corners& a, const Corners& b, std::size_t first) {
  int sum = 0;
  for (std::size_t k = first; k < 3; ++k) {
    const int side = orientation(b[0], b[1], b[2], a[k]);
    if (side == 0) return false;
    sum += side;
  }
  return static_cast<std::size_t>(std::abs(sum)) == 3 - first;
}

/// The corners of a face, in another order.
struct TurnedFace {
  Triangle vertices;
  std::array<const Vec3*, 3> corner;

  explicit TurnedFace(const PlacedFace& face)
      : vertices(face.vertices), corner{&face.corner[0], &face.corner[1], &face.corner[2]} {}
  void swap(std::size_t i, std::size_t j) {
    std::swap(vertices[i], vertices[j]);
    std::swap(corner[i], corner[j]);
  }
  Corners corners() const { return {*corner[0], *corner[1], *corner[2]}; }
};

/// Turns both faces so that what they share comes first, in the same order. Returns how many corners that is.
std::size_t bring_shared_first(TurnedFace& a, TurnedFace& b) {
  std::size_t shared = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = shared; j < 3; ++j) {
      if (a.vertices[i] != b.vertices[j]) continue;
      a.swap(i, shared);
      b.swap(j, shared);
      ++shared;
      break;
    }
  }
  return shared;
}

/// Whether the plane across an axis, through what two faces share, parts them by more than rounding.
bool are_parted(const TurnedFace& s, const TurnedFace& t, std::size_t shared, const Vec3& axis) {
  const Vec3& origin = *s.corner[0];
  double least = 1e300;
  double greatest = -1e300;
  for (std::size_t k = shared; k < 3; ++k) {
    least = std::min(least, dot(axis, *s.corner[k] - origin));
    greatest = std::max(greatest, dot(axis, *t.corner[k] - origin));
  }
  if (!(shared == 0 ? least > greatest : least > 0.0 && greatest < 0.0)) return false;
  double largest = std::max({std::fabs(origin.x), std::fabs(origin.y), std::fabs(origin.z)});
  for (std::size_t k = shared; k < 3; ++k) {
    for (const Vec3* p : {s.corner[k], t.corner[k]})
      largest = std::max({largest, std::fabs(p->x), std::fabs(p->y), std::fabs(p->z)});
  }
  const double margin = 1e-14 * length(axis) * largest;
  if (shared == 0) return least > greatest + margin;
  return least > margin && greatest < -margin;
}

/// Whether the plane across the line from one face's middle to the other's, or one between them, parts them:
/// true only if they meet nowhere but in what they share. Cheap; most pairs end here.
bool are_clearly_apart(const TurnedFace& a, const TurnedFace& b, std::size_t shared) {
  const auto& s = a.corner;
  const auto& t = b.corner;
  if (shared == 0) return are_parted(a, b, shared, (*s[0] + *s[1] + *s[2]) - (*t[0] + *t[1] + *t[2]));
  if (shared == 2) {
    const Vec3 edge = *s[1] - *s[0];
    const Vec3 way = *s[2] - *t[2];
    return are_parted(a, b, shared, way - (dot(way, edge) / length_sq(edge)) * edge);
  }
  if (are_parted(a, b, shared, (*s[1] + *s[2]) - (*t[1] + *t[2]))) return true;
  const auto direction = [](const Vec3& from, const Vec3& to) {
    const double size = length(to - from);
    return size > 0.0 ? (1.0 / size) * (to - from) : Vec3{};
  };
  return are_parted(
      a, b, shared,
      direction(*s[0], *s[1]) + direction(*s[0], *s[2]) - direction(*t[0], *t[1]) - direction(*t[0], *t[2]));
}

}  // namespace

bool are_in_contact(const PlacedFace& a, const PlacedFace& b) {
  TurnedFace first(a);
  TurnedFace second(b);
  const std::size_t shared = bring_shared_first(first, second);
  if (shared == 3) return true;
  if (are_clearly_apart(first, second, shared)) return false;
  const Corners s = first.corners();
  const Corners t = second.corners();
  if (shared == 2) {
    if (orientation(s[0], s[1], s[2], t[2]) != 0) return false;
    const InPlane side(s);
    return !side.has_area() || side(s[0], s[1], t[2]) >= 0;
  }
  if (is_beside(s, t, shared) || is_beside(t, s, shared)) return false;
  // With one corner shared, what the faces have in common leaves one of them across the side opposite to it.
  if (segment_meets(s[1], s[2], t) || segment_meets(t[1], t[2], s)) return true;
  if (shared == 1) return false;
  return segment_meets(s[0], s[1], t) || segment_meets(s[0], s[2], t) || segment_meets(t[0], t[1], s) ||
         segment_meets(t[0], t[2], s);
}

}  // namespace palpate::simplify

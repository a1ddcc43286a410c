#include "core/simplify/cover/cover_check.h"

#include <algorithm>

namespace palpate::simplify {
namespace {

constexpr std::size_t kMostPiecesOfFace = 1000;
constexpr std::size_t kMostPiecesOfInput = 100;

/// Relative to a piece's extent: heights over a cutting plane below this are on it.
constexpr double kOnPlane = 1e-8;

double distance_sq(const Vec3& p, const TriangleCorners& t) {
  return distance_sq_to_triangle(p, t[0], t[1], t[2]);
}

/// Of the longest two sides' squares, the least square of a normal that has a direction.
constexpr double kLeastNormalSq = 1e-20;

/// Whether a point is surely farther from a triangle.
bool is_beyond(double limit_sq, const Vec3& p, const BoxedTriangle& b) {
  if (kBoxSlack * distance_sq_to_box(p, b.box) > limit_sq) return true;
  const double height = dot(p - b.corner[0], b.normal);
  return kBoxSlack * height * height > limit_sq * b.normal_sq && b.normal_sq > 0.0;
}

}  // namespace

BoxedTriangle::BoxedTriangle(const TriangleCorners& t)
    : corner(t), box(bounding_box(t)), normal(cross(t[1] - t[0], t[2] - t[0])) {
  const double square = length_sq(normal);
  if (square > kLeastNormalSq * length_sq(t[1] - t[0]) * length_sq(t[2] - t[0])) normal_sq = square;
}

bool CoverTest::is_within(const Piece& piece, const TriangleCorners& b) {
  double farthest = 0.0;
  for (std::size_t i = 0; i < piece.size; ++i) {
    const double here = distance_sq(piece.corner[i], b);
    if (!(here <= limit_sq_)) return false;
    farthest = std::max(farthest, here);
  }
  reach_sq_ = std::max(reach_sq_, farthest);
  return true;
}

/// Returns false if the piece has too many corners to be cut further.
bool CoverTest::push(const Piece& piece) {
  if (piece.size < 3) return true;
  if (piece.size + 3 > kMostCorners) return false;
  open_.push_back(piece);
  return true;
}

namespace {

/// Which side of a plane the corners of a piece are on.
struct Heights {
  std::array<double, 12> of{};
  double slack = 0.0;
  bool any_above = false;
  bool any_below = false;

  template <typename Piece>
  Heights(const Piece& piece, const Vec3& foot, const Vec3& normal) {
    double least = 0.0;
    double greatest = 0.0;
    for (std::size_t i = 0; i < piece.size; ++i) {
      of[i] = dot(piece.corner[i] - foot, normal);
      least = std::min(least, of[i]);
      greatest = std::max(greatest, of[i]);
    }
    slack = kOnPlane * (greatest - least);
    any_above = greatest > slack;
    any_below = least < -slack;
  }
};

template <typename Piece>
void divide(const Piece& piece, const Heights& height, Piece& above, Piece& below) {
  for (std::size_t i = 0; i < piece.size; ++i) {
    const std::size_t j = (i + 1) % piece.size;
    const double here = height.of[i];
    const double next = height.of[j];
    if (here >= -height.slack) above.add(piece.corner[i]);
    if (here <= height.slack) below.add(piece.corner[i]);
    if ((here > height.slack && next < -height.slack) || (here < -height.slack && next > height.slack)) {
      const Vec3 crossing = piece.corner[i] + (here / (here - next)) * (piece.corner[j] - piece.corner[i]);
      above.add(crossing);
      below.add(crossing);
    }
  }
}

}  // namespace

/// Returns false, with nothing pushed, if none of the planes cuts the piece or no part of it is above b.
bool CoverTest::cut_along(const Piece& piece, const TriangleCorners& b) {
  const Vec3 normal = cross(b[1] - b[0], b[2] - b[0]);
  Piece inside = piece;
  std::array<Piece, 3> outside;
  std::size_t count = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const Heights height(inside, b[k], cross(normal, b[(k + 1) % 3] - b[k]));
    if (!height.any_above) return false;
    if (!height.any_below) continue;
    Piece above;
    divide(inside, height, above, outside[count++]);
    inside = above;
  }
  if (count == 0) return false;
  for (std::size_t k = 0; k < count; ++k) {
    outside[k].cut_along = &b;
    if (!push(outside[k])) return false;
  }
  inside.cut_along = &b;
  return push(inside);
}

bool CoverTest::halve(const Piece& piece, const Vec3& middle) {
  Vec3 farthest;
  for (std::size_t i = 0; i < piece.size; ++i) {
    const Vec3 way = piece.corner[i] - middle;
    if (length_sq(way) > length_sq(farthest)) farthest = way;
  }
  Piece above;
  Piece below;
  divide(piece, Heights(piece, middle, farthest), above, below);
  return push(above) && push(below);
}

template <typename FindNearest, typename Use>
bool CoverTest::run(const TriangleCorners& triangle, std::size_t most_pieces, const FindNearest& find_nearest,
                    const Use& use) {
  open_.clear();
  reach_sq_ = 0.0;
  Piece whole;
  for (const Vec3& p : triangle) whole.add(p);
  open_.push_back(whole);
  for (std::size_t pieces = 0; !open_.empty(); ++pieces) {
    if (pieces == most_pieces) return false;
    const Piece piece = open_.back();
    open_.pop_back();
    Vec3 middle;
    for (std::size_t i = 0; i < piece.size; ++i) middle = middle + piece.corner[i];
    middle = (1.0 / static_cast<double>(piece.size)) * middle;
    const TriangleCorners* b = find_nearest(middle);
    if (b == nullptr) return false;
    if (is_within(piece, *b)) {
      use(b);
      continue;
    }
    const std::size_t open = open_.size();
    if (piece.cut_along != b && cut_along(piece, *b)) continue;
    open_.resize(open);
    if (!halve(piece, middle)) return false;
  }
  return true;
}

bool CoverTest::is_covered(const TriangleCorners& triangle, const TriangleTree& by) {
  if (!std::all_of(triangle.begin(), triangle.end(), [&](const Vec3& p) { return is_near(p, by); }))
    return false;
  return is_inside_covered(triangle, by);
}

bool CoverTest::is_inside_covered(const TriangleCorners& triangle, const TriangleTree& by) {
  return run(
      triangle, kMostPiecesOfFace, [&](const Vec3& p) { return by.nearest(p, bound_sq()).triangle; },
      [](const TriangleCorners* /*b*/) {});
}

bool CoverTest::is_covered(const BoxedTriangle& triangle, std::span<const BoxedTriangle> by,
                           std::vector<Index>& used) {
  used.clear();
  near_.clear();
  for (const BoxedTriangle& b : by) {
    if (may_be_within(limit_sq_, triangle.box, b.box)) near_.push_back(&b);
  }
  const auto nearest = [&](const Vec3& p) {
    const TriangleCorners* best = nullptr;
    double least = limit_sq_;
    if (hint_ < by.size()) least = std::min(least, distance_sq(p, by[hint_].corner));
    for (const BoxedTriangle* b : near_) {
      if (is_beyond(least, p, *b)) continue;
      const double here = distance_sq(p, b->corner);
      if (here > least || (best != nullptr && here == least)) continue;
      least = here;
      best = &b->corner;
    }
    return best;
  };
  const auto use = [&](const TriangleCorners* b) {
    const auto is_it = [b](const BoxedTriangle& of) { return &of.corner == b; };
    const auto number = static_cast<Index>(std::find_if(by.begin(), by.end(), is_it) - by.begin());
    hint_ = number;
    if (std::find(used.begin(), used.end(), number) == used.end()) used.push_back(number);
  };
  return run(triangle.corner, kMostPiecesOfInput, nearest, use);
}

bool CoverTest::is_near(const Vec3& p, const TriangleTree& by) const {
  return by.is_below(p, bound_sq());
}

bool CoverTest::is_near(const Vec3& p, std::span<const BoxedTriangle> by) const {
  return std::any_of(by.begin(), by.end(), [&](const BoxedTriangle& b) {
    return !is_beyond(limit_sq_, p, b) && distance_sq(p, b.corner) <= limit_sq_;
  });
}

}  // namespace palpate::simplify

#include "core/simplify/cover/sheet_cover.h"

#include <algorithm>
#include <cmath>

namespace palpate::simplify {
namespace {

/// Of a triangle's area, what is seen of it at least; and of the square of its longest edge, what is its
/// area.
constexpr double kLeastSeen = 0.25;
constexpr double kLeastArea = 1e-3;

/// Of the longest edge: what is nearer than this to a side only touches it.
constexpr double kTouch = 1e-12;

/// Of the longest edge: what the limit leaves to that, and to rounding.
constexpr double kSlack = 1e-7;

bool have_boxes_apart(const Tile& a, const Tile& b) {
  return a.least_x >= b.greatest_x || b.least_x >= a.greatest_x || a.least_y >= b.greatest_y ||
         b.least_y >= a.greatest_y;
}

double seen_length_sq(const Vec3& v) {
  return v.x * v.x + v.y * v.y;
}

/// What is left to what only touches, and to rounding, in a difference of heights between the two.
double leeway_between(const Tile& t, const Tile& tile) {
  return kSlack * std::sqrt(std::max(t.reach_sq, tile.reach_sq));
}

}  // namespace

void SheetCover::look_against(const Vec3& direction, const Vec3& origin) {
  origin_ = origin;
  const double size = length(direction);
  const Vec3 up = size > 0.0 ? (1.0 / size) * direction : Vec3{0.0, 0.0, 1.0};
  const Vec3 across = cross(std::fabs(up.x) < 0.6 ? Vec3{1.0, 0.0, 0.0} : Vec3{0.0, 1.0, 0.0}, up);
  axes_[0] = (1.0 / length(across)) * across;
  axes_[1] = cross(up, axes_[0]);
  axes_[2] = up;
}

Tile SheetCover::tile(const Triangle& number, const std::array<Vec3, 3>& corner) const {
  Tile tile;
  tile.number = number;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3 from = corner[k] - origin_;
    tile.at[k] = {dot(from, axes_[0]), dot(from, axes_[1]), dot(from, axes_[2])};
  }
  const auto& [p, q, r] = tile.at;
  const Vec3 normal = cross(q - p, r - p);
  tile.reach_sq = std::max({seen_length_sq(q - p), seen_length_sq(r - q), seen_length_sq(p - r)});
  tile.faces_viewer = normal.z > 2.0 * kLeastArea * tile.reach_sq &&
                      normal.z * normal.z > kLeastSeen * kLeastSeen * length_sq(normal);
  if (!tile.faces_viewer) return tile;
  tile.slope_x = -normal.x / normal.z;
  tile.slope_y = -normal.y / normal.z;
  tile.least_x = std::min({p.x, q.x, r.x});
  tile.greatest_x = std::max({p.x, q.x, r.x});
  tile.least_y = std::min({p.y, q.y, r.y});
  tile.greatest_y = std::max({p.y, q.y, r.y});
  return tile;
}

/// How far the corners of one tile are within each side of another, times that side's length; what touches a
/// side is not within. Returns false, without the rest, if none is within one of them: a side parts the two.
bool SheetCover::measure_sides(const Tile& of, const Tile& corners, Sides& within) {
  const double touch = kTouch * of.reach_sq;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3& p = of.at[k];
    const Vec3& q = of.at[(k + 1) % 3];
    bool parts = true;
    for (std::size_t c = 0; c < 3; ++c) {
      const Vec3& r = corners.at[c];
      within[k][c] = (q.x - p.x) * (r.y - p.y) - (q.y - p.y) * (r.x - p.x) - touch;
      parts = parts && within[k][c] <= 0.0;
    }
    if (parts) return false;
  }
  return true;
}

/// Takes note of the edges of a tile that meet the inside of t, `within` being how far its corners are within
/// the sides of t. Returns whether their heights are within the limit there.
bool SheetCover::take_edges(const Tile& t, const Tile& tile, const Sides& within, double leeway) {
  for (std::size_t e = 0; e < 3; ++e) {
    const std::size_t next = (e + 1) % 3;
    const std::pair<Index, Index> across{tile.number[next], tile.number[e]};
    if (const auto other = std::find(open_.begin(), open_.end(), across); other != open_.end()) {
      *other = open_.back();
      open_.pop_back();
      continue;
    }
    double from = 0.0;
    double to = 1.0;
    bool is_beside = false;
    for (const std::array<double, 3>& side : within) {
      const double here = side[e];
      const double there = side[next];
      is_beside = is_beside || (here <= 0.0 && there <= 0.0);
      if (here < 0.0 && there > 0.0) from = std::max(from, here / (here - there));
      if (here > 0.0 && there < 0.0) to = std::min(to, here / (here - there));
    }
    if (is_beside || from > to) continue;
    const Vec3 way = tile.at[next] - tile.at[e];
    if (is_high(t, tile.at[e] + from * way, leeway) || is_high(t, tile.at[e] + to * way, leeway))
      return false;
    open_.emplace_back(tile.number[e], tile.number[next]);
  }
  return true;
}

/// Which corners of t are over the tile, `within` being how far they are within its sides. Here what touches
/// counts.
std::array<bool, 3> SheetCover::find_corners(const Tile& tile, const Sides& within) {
  const double touch = -3.0 * kTouch * tile.reach_sq;
  std::array<bool, 3> is_over{};
  for (std::size_t c = 0; c < 3; ++c)
    is_over[c] = within[0][c] >= touch && within[1][c] >= touch && within[2][c] >= touch;
  return is_over;
}

/// Whether a point may be farther than the limit from the plane of t.
bool SheetCover::is_high(const Tile& t, const Vec3& p, double leeway) {
  const double height = std::fabs(p.z - t.height_at(p.x, p.y)) + leeway;
  if (!(height <= limit_)) return true;
  reach_ = std::max(reach_, height);
  return false;
}

bool SheetCover::is_covered(const Tile& t, std::span<const Tile> by, std::vector<Index>& used) {
  used.clear();
  open_.clear();
  reach_ = 0.0;
  if (!t.faces_viewer) return false;
  std::array<bool, 3> has_corner{};  // of t: over a tile
  for (Index i = 0; i < by.size(); ++i) {
    const Tile& tile = by[i];
    if (!tile.faces_viewer || have_boxes_apart(t, tile)) continue;
    Sides corners;
    Sides within;
    if (!measure_sides(tile, t, corners) || !measure_sides(t, tile, within)) continue;
    const double leeway = leeway_between(t, tile);
    const std::array<bool, 3> is_over = find_corners(tile, corners);
    for (std::size_t c = 0; c < 3; ++c) {
      if (is_over[c] && is_high(tile, t.at[c], leeway)) return false;
      has_corner[c] = has_corner[c] || is_over[c];
    }
    if (is_over[0] && is_over[1] && is_over[2]) {  // a tile is convex: enough by itself
      used.assign(1, i);
      return true;
    }
    if (!take_edges(t, tile, within, leeway)) return false;
    used.push_back(i);
  }
  return has_corner[0] && has_corner[1] && has_corner[2] && open_.empty();
}

}  // namespace palpate::simplify

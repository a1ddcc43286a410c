// Is every point of a triangle within a distance of a piece of a surface that lies along it like a sheet? The
// quick half of a decision with a proof: "yes" is certain, "no" says nothing (CoverTest decides then).
#pragma once

#include <array>
#include <span>
#include <utility>
#include <vector>

#include "core/base/types.h"

namespace palpate::simplify {

/// A triangle of an oriented surface, seen along a direction.
struct Tile {
  Triangle number{};          ///< of its corners
  std::array<Vec3, 3> at;     ///< where they are: x and y across the direction, z along it
  bool faces_viewer = false;  ///< turned to the viewer, neither steep nor a needle; else the rest is not set
  double slope_x = 0.0;       ///< of its plane
  double slope_y = 0.0;
  double reach_sq = 0.0;  ///< square of the longest edge, as it is seen
  double least_x = 0.0;   ///< the box around it
  double greatest_x = 0.0;
  double least_y = 0.0;
  double greatest_y = 0.0;

  double height_at(double x, double y) const {
    return at[0].z + slope_x * (x - at[0].x) + slope_y * (y - at[0].y);
  }
};

/// Answers such questions, along one direction after another.
///
/// Seen along it, a triangle T and tiles that face the viewer are triangles of a plane, and heights over that
/// plane are linear on each. Let each edge of such a tile that meets the inside of T be the edge of two of
/// them. Then what they cover of the inside of T is open and closed there, so it is all of it; and the
/// heights differ most at a corner of T, at a corner of a tile, or where edges cross. If by no more than the
/// limit at any of these, T is within the limit of these tiles.
class SheetCover {
 public:
  explicit SheetCover(double limit) : limit_(limit) {}

  /// Looks against `direction` (of any length but 0) from now on; heights count from `origin`.
  void look_against(const Vec3& direction, const Vec3& origin);

  Tile tile(const Triangle& number, const std::array<Vec3, 3>& corner) const;

  /// Whether `t` is surely within the limit of some tiles of `by`, which belong to one oriented surface.
  /// `used` gets the places in `by` of those that are enough; it is cleared first.
  bool is_covered(const Tile& t, std::span<const Tile> by, std::vector<Index>& used);

  void set_limit(double limit) { limit_ = limit; }
  /// Where the last answer was yes: no point of the triangle is farther than this from those tiles. At most
  /// the limit.
  double reach() const { return reach_; }

 private:
  using Sides = std::array<std::array<double, 3>, 3>;
  static bool measure_sides(const Tile& of, const Tile& corners, Sides& within);
  static std::array<bool, 3> find_corners(const Tile& tile, const Sides& within);
  bool is_high(const Tile& t, const Vec3& p, double leeway);
  bool take_edges(const Tile& t, const Tile& tile, const Sides& within, double leeway);

  double limit_;
  double reach_ = 0.0;
  Vec3 origin_;
  std::array<Vec3, 3> axes_;
  std::vector<std::pair<Index, Index>> open_;  ///< edges that meet the triangle, of one tile so far
};

}  // namespace palpate::simplify

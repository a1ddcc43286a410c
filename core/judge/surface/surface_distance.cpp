#include <algorithm>
#include <array>
#include <cmath>
#include <queue>

#include "core/base/error.h"
#include "core/judge/mesh/compensated_sum.h"
#include "core/judge/mesh/tet_shape.h"
#include "core/judge/mesh/vertex_links.h"
#include "core/judge/surface/surface.h"
#include "core/judge/surface/triangle_tree.h"

namespace palpate::judge {
namespace {

/// A convex, flat part of a triangle of the first surface.
struct Piece {
  std::vector<Vec3> corners;
  Vec3 middle;
  Index nearest = kNoIndex;    ///< triangle of the second surface that is nearest to the middle
  Index cut_along = kNoIndex;  ///< triangle along whose sides it was cut out: again would gain nothing
  double bound = 0.0;          ///< none of its points is farther from the second surface
};

struct LessBound {
  bool operator()(const Piece& a, const Piece& b) const { return a.bound < b.bound; }
};

using Polygon = std::vector<Vec3>;

/// Heights of a polygon's corners over a plane, and which of them count as off it.
struct Heights {
  std::vector<double> of;
  double greatest = 0.0;
  double least = 0.0;
  double slack = 0.0;

  Heights(const Polygon& polygon, const Vec3& foot, const Vec3& normal) {
    for (const Vec3& p : polygon) {
      of.push_back(dot(p - foot, normal));
      greatest = std::max(greatest, of.back());
      least = std::min(least, of.back());
    }
    slack = kSlack * (greatest - least);
  }

  bool are_above() const { return !(least < -slack); }
  bool are_below() const { return !(greatest > slack); }

  /// Relative to the polygon's extent: what is cut off is at least so thick.
  static constexpr double kSlack = 1e-8;
};

/// Cuts a convex polygon by a plane: the parts above and below it.
std::pair<Polygon, Polygon> cut(const Polygon& polygon, const Heights& height) {
  std::pair<Polygon, Polygon> parts;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const std::size_t j = (i + 1) % polygon.size();
    const double here = height.of[i];
    const double next = height.of[j];
    if (here >= -height.slack) parts.first.push_back(polygon[i]);
    if (here <= height.slack) parts.second.push_back(polygon[i]);
    if ((here > height.slack && next < -height.slack) || (here < -height.slack && next > height.slack)) {
      const Vec3 crossing = polygon[i] + (here / (here - next)) * (polygon[j] - polygon[i]);
      parts.first.push_back(crossing);
      parts.second.push_back(crossing);
    }
  }
  return parts;
}

/// Brackets the greatest distance from one surface to another by branch and bound.
class Bracketing {
 public:
  Bracketing(std::span<const Corners> from, const TriangleTree& to, double diagonal,
             const SurfaceDistanceOptions& options)
      : from_(from), to_(to), options_(options), absolute_gap_(options.absolute_gap * diagonal) {}

  DirectedDistance run() {
    for (const Corners& t : from_) {
      for (const Vec3& p : {t.a, t.b, t.c}) hint_ = look(p, hint_).triangle;
    }
    for (const Corners& t : from_) {
      hint_ = add({t.a, t.b, t.c}, std::numeric_limits<double>::infinity(), hint_);
    }
    while (!open_.empty() && open_.top().bound > good_enough() && pieces_ < options_.max_pieces) {
      const Piece piece = open_.top();
      open_.pop();
      for (const Vec3& p : piece.corners) look(p, piece.nearest);
      if (!cut_along_nearest(piece)) halve(piece);
    }
    DirectedDistance result;
    result.lower = lower_;
    result.upper = std::max({lower_, settled_, open_.empty() ? 0.0 : open_.top().bound});
    return result;
  }

 private:
  double good_enough() const {
    return std::max(lower_ * (1.0 + options_.relative_gap), lower_ + absolute_gap_);
  }

  Nearest look(const Vec3& point, Index hint) {
    const Nearest found = to_.nearest(point, hint);
    lower_ = std::max(lower_, std::sqrt(found.distance_sq));
    return found;
  }

  /// Greatest distance from the corners to one triangle: none of the polygon's points is farther from it.
  double bound_by(const Polygon& polygon, Index triangle) const {
    double largest = 0.0;
    for (const Vec3& p : polygon) largest = std::max(largest, distance_sq(p, to_.triangle(triangle)));
    return std::sqrt(largest);
  }

  /// Puts a polygon by or, if it may still matter, on the heap. `bound` is what is known already, `near` a
  /// triangle that it may lie above. Returns a triangle near it.
  Index add(Polygon&& polygon, double bound, Index near, Index cut_along = kNoIndex) {
    if (polygon.size() < 3) return near;
    ++pieces_;
    if (near != kNoIndex) bound = std::min(bound, bound_by(polygon, near));
    if (bound <= good_enough()) {
      settled_ = std::max(settled_, bound);
      return near;
    }
    Piece piece;
    for (const Vec3& p : polygon) piece.middle = piece.middle + p;
    piece.middle = (1.0 / static_cast<double>(polygon.size())) * piece.middle;
    double reach = 0.0;
    for (const Vec3& p : polygon) reach = std::max(reach, length(p - piece.middle));
    const Nearest found = look(piece.middle, near);
    piece.nearest = found.triangle;
    piece.bound = std::min({bound, bound_by(polygon, found.triangle), std::sqrt(found.distance_sq) + reach});
    if (piece.bound <= good_enough()) {
      settled_ = std::max(settled_, piece.bound);
      return found.triangle;
    }
    piece.corners = std::move(polygon);
    piece.cut_along = cut_along;
    open_.push(std::move(piece));
    return found.triangle;
  }

  /// Cuts a piece by the planes that stand on the sides of the triangle nearest to its middle. Returns false
  /// and does nothing if none of them cuts it or nothing of it is above the triangle.
  bool cut_along_nearest(const Piece& piece) {
    if (piece.nearest == piece.cut_along) return false;
    const Corners& t = to_.triangle(piece.nearest);
    const std::array<Vec3, 3> foot{t.a, t.b, t.c};
    const Vec3 normal = cross(t.b - t.a, t.c - t.a);
    Polygon inside = piece.corners;
    std::vector<Polygon> outside;
    for (std::size_t k = 0; k < 3; ++k) {
      const Heights height(inside, foot[k], cross(normal, foot[(k + 1) % 3] - foot[k]));
      if (height.are_below()) return false;
      if (height.are_above()) continue;
      std::pair<Polygon, Polygon> parts = cut(inside, height);
      inside = std::move(parts.first);
      outside.push_back(std::move(parts.second));
    }
    if (outside.empty()) return false;
    add(std::move(inside), piece.bound, piece.nearest, piece.nearest);
    for (Polygon& polygon : outside) add(std::move(polygon), piece.bound, piece.nearest, piece.nearest);
    return true;
  }

  /// Cuts a piece through its middle, across the direction to its farthest corner.
  void halve(const Piece& piece) {
    Vec3 longest;
    for (const Vec3& p : piece.corners) {
      if (length_sq(p - piece.middle) > length_sq(longest)) longest = p - piece.middle;
    }
    std::pair<Polygon, Polygon> parts = cut(piece.corners, Heights(piece.corners, piece.middle, longest));
    add(std::move(parts.first), piece.bound, piece.nearest);
    add(std::move(parts.second), piece.bound, piece.nearest);
  }

  std::span<const Corners> from_;
  const TriangleTree& to_;
  const SurfaceDistanceOptions& options_;
  double absolute_gap_ = 0.0;
  double lower_ = 0.0;
  double settled_ = 0.0;  // greatest bound of the pieces that were put by
  std::uint64_t pieces_ = 0;
  Index hint_ = kNoIndex;
  std::priority_queue<Piece, std::vector<Piece>, LessBound> open_;
};

/// Mean distance, weighted by area: each triangle is divided into n^2 equal ones, one sample in the middle of
/// each. The distance changes no faster than the way that is gone, so a sample is off by at most the greatest
/// distance between the middle and a corner.
void measure_mean(std::span<const Corners> from, const TriangleTree& to, double spacing,
                  DirectedDistance& result) {
  if (!(spacing > 0.0)) return;  // both surfaces are one point
  CompensatedSum area_sum;
  CompensatedSum distance_sum;
  CompensatedSum error_sum;
  Index hint = kNoIndex;
  for (const Corners& t : from) {
    const double area = 0.5 * length(cross(t.b - t.a, t.c - t.a));
    const double longest = std::max({length(t.b - t.a), length(t.c - t.b), length(t.a - t.c)});
    const int n = std::max(1, static_cast<int>(std::ceil(longest / spacing)));
    const double cell = area / (double(n) * n);
    const Vec3 center = (1.0 / 3.0) * (t.a + t.b + t.c);
    const double reach = std::max({length(t.a - center), length(t.b - center), length(t.c - center)}) / n;
    const auto sample = [&](double u, double v) {
      const Vec3 p = t.a + (u / (3.0 * n)) * (t.b - t.a) + (v / (3.0 * n)) * (t.c - t.a);
      const Nearest found = to.nearest(p, hint);
      hint = found.triangle;
      distance_sum.add(cell * std::sqrt(found.distance_sq));
    };
    for (int i = 0; i < n; ++i) {
      for (int j = 0; i + j < n; ++j) {
        sample(3.0 * i + 1.0, 3.0 * j + 1.0);
        if (i + j + 1 < n) sample(3.0 * i + 2.0, 3.0 * j + 2.0);
      }
    }
    area_sum.add(area);
    error_sum.add(area * reach);
  }
  if (area_sum.value() <= 0.0) return;
  result.mean = distance_sum.value() / area_sum.value();
  result.mean_error = error_sum.value() / area_sum.value();
}

/// The triangles of a surface with the coordinates in units of 2^exponent.
std::vector<Corners> scaled_corners(const SurfaceMesh& surface, int exponent) {
  std::vector<Corners> triangles;
  triangles.reserve(surface.triangles.size());
  const auto point = [&](Index v) {
    require(v < surface.points.size(), "surface distance: a triangle's vertex does not exist");
    const Vec3& p = surface.points[v];
    require(is_finite(p), "surface distance: a point is not finite");
    if (exponent == 0) return p;
    return Vec3{std::scalbn(p.x, -exponent), std::scalbn(p.y, -exponent), std::scalbn(p.z, -exponent)};
  };
  for (const Triangle& t : surface.triangles) triangles.push_back({point(t[0]), point(t[1]), point(t[2])});
  return triangles;
}

DirectedDistance measure_directed(std::span<const Corners> from, const TriangleTree& to, double diagonal,
                                  const SurfaceDistanceOptions& options) {
  DirectedDistance result = Bracketing(from, to, diagonal, options).run();
  measure_mean(from, to, options.mean_spacing * diagonal, result);
  return result;
}

void unscale(DirectedDistance& distance, int exponent) {
  for (double* value : {&distance.lower, &distance.upper, &distance.mean, &distance.mean_error}) {
    *value = std::min(std::scalbn(*value, exponent), std::numeric_limits<double>::max());
  }
}

}  // namespace

SurfaceMesh build_boundary(const TetMesh& mesh) {
  SurfaceMesh surface;
  surface.points = mesh.points;
  for_each_boundary_face(mesh, [&](const Triangle& t) {
    if (std::all_of(t.begin(), t.end(), [&](Index i) { return is_finite(mesh.points[i]); }))
      surface.triangles.push_back(t);
  });
  return surface;
}

SurfaceDistance measure_surface_distance(const SurfaceMesh& a, const SurfaceMesh& b,
                                         const SurfaceDistanceOptions& options) {
  require(options.relative_gap >= 0.0 && options.absolute_gap > 0.0 && options.mean_spacing >= 1e-4,
          "surface distance: the gaps or the spacing are too small");
  SurfaceDistance result;
  if (a.triangles.empty() || b.triangles.empty()) {
    if (a.triangles.empty() && b.triangles.empty()) return result;
    const double infinite = std::numeric_limits<double>::infinity();
    result.forward = result.backward = {infinite, infinite, infinite, infinite};
    return result;
  }
  const int exponent = std::max(length_exponent(a.points), length_exponent(b.points));
  const std::vector<Corners> first = scaled_corners(a, exponent);
  const std::vector<Corners> second = scaled_corners(b, exponent);
  Box box;
  for (const Corners& t : first) box.add(t);
  for (const Corners& t : second) box.add(t);
  const double diagonal = length(box.high - box.low);
  result.forward = measure_directed(first, TriangleTree(second), diagonal, options);
  result.backward = measure_directed(second, TriangleTree(first), diagonal, options);
  result.diagonal = std::scalbn(diagonal, exponent);
  unscale(result.forward, exponent);
  unscale(result.backward, exponent);
  return result;
}

}  // namespace palpate::judge

#include <algorithm>
#include <array>
#include <cmath>
#include <queue>

#include "core/base/error.h"
#include "core/judge/compensated_sum.h"
#include "core/judge/surface.h"
#include "core/judge/tet_shape.h"
#include "core/judge/triangle_tree.h"
#include "core/judge/vertex_links.h"

namespace palpate::judge {
namespace {

/// A point of the first surface and what is nearest to it on the second.
struct Probe {
  Vec3 point;
  Index nearest = kNoIndex;
  double distance = 0.0;
};

/// A part of a triangle of the first surface, and a bound on the distance from any of its points.
struct Piece {
  std::array<Probe, 3> corner;
  Probe middle;
  double bound = 0.0;
};

struct LessBound {
  bool operator()(const Piece& a, const Piece& b) const { return a.bound < b.bound; }
};

/// A convex part that is being cut.
using Polygon = std::vector<Vec3>;

/// Cuts a convex polygon by the plane on which `height` is 0: what has height >= 0 and what has height <= 0.
/// A corner within `slack` of the plane is on it.
std::pair<Polygon, Polygon> cut(const Polygon& polygon, const std::vector<double>& height, double slack) {
  std::pair<Polygon, Polygon> parts;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const std::size_t j = (i + 1) % polygon.size();
    if (height[i] >= -slack) parts.first.push_back(polygon[i]);
    if (height[i] <= slack) parts.second.push_back(polygon[i]);
    if ((height[i] > slack && height[j] < -slack) || (height[i] < -slack && height[j] > slack)) {
      const Vec3 crossing = polygon[i] + (height[i] / (height[i] - height[j])) * (polygon[j] - polygon[i]);
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
    for (const Corners& t : from_) add_triangle(t);
    while (!open_.empty() && open_.top().bound > good_enough() && pieces_ < options_.max_pieces) {
      const Piece piece = open_.top();
      open_.pop();
      split(piece);
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

  Probe look(const Vec3& point, Index hint) {
    const Nearest found = to_.nearest(point, hint);
    const double distance = std::sqrt(found.distance_sq);
    lower_ = std::max(lower_, distance);
    return {point, found.triangle, distance};
  }

  void add_triangle(const Corners& t) {
    Piece piece;
    piece.corner[0] = look(t.a, hint_);
    piece.corner[1] = look(t.b, piece.corner[0].nearest);
    piece.corner[2] = look(t.c, piece.corner[1].nearest);
    hint_ = piece.corner[2].nearest;
    add(piece, std::numeric_limits<double>::infinity());
  }

  /// Greatest distance from the corners to one triangle: none of the piece's points is farther from it.
  double bound_by(const Piece& piece, Index triangle) const {
    double largest = 0.0;
    for (const Probe& c : piece.corner) {
      largest = std::max(largest, distance_sq(c.point, to_.triangle(triangle)));
    }
    return std::sqrt(largest);
  }

  /// Puts a piece by or, if it may still matter, on the heap.
  void add(Piece& piece, double bound) {
    ++pieces_;
    for (const Probe& c : piece.corner) {
      if (bound > good_enough()) bound = std::min(bound, bound_by(piece, c.nearest));
    }
    if (bound > good_enough()) {
      const std::array<Probe, 3>& c = piece.corner;
      piece.middle = look((1.0 / 3.0) * (c[0].point + c[1].point + c[2].point), c[0].nearest);
      double reach = 0.0;
      for (const Probe& p : c) reach = std::max(reach, length(p.point - piece.middle.point));
      bound = std::min({bound, bound_by(piece, piece.middle.nearest), piece.middle.distance + reach});
    }
    if (bound <= good_enough()) {
      settled_ = std::max(settled_, bound);
      return;
    }
    piece.bound = bound;
    open_.push(piece);
  }

  void split(const Piece& piece) {
    if (!split_along_nearest(piece)) halve(piece);
  }

  /// Cuts a piece by the planes that stand on the sides of the triangle nearest to its middle. Returns false
  /// and does nothing if none of them cuts it or nothing of it is above the triangle.
  bool split_along_nearest(const Piece& piece) {
    const Index target = piece.middle.nearest;
    const Corners& t = to_.triangle(target);
    const std::array<Vec3, 3> foot{t.a, t.b, t.c};
    const Vec3 normal = cross(t.b - t.a, t.c - t.a);
    Polygon inside{piece.corner[0].point, piece.corner[1].point, piece.corner[2].point};
    std::vector<Polygon> outside;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 inward = cross(normal, foot[(k + 1) % 3] - foot[k]);
      std::vector<double> height;
      double largest = 0.0;
      double least = 0.0;
      for (const Vec3& p : inside) {
        height.push_back(dot(p - foot[k], inward));
        largest = std::max(largest, height.back());
        least = std::min(least, height.back());
      }
      const double slack = kSlack * (largest - least);
      if (!(largest > slack)) return false;
      if (!(least < -slack)) continue;
      std::pair<Polygon, Polygon> parts = cut(inside, height, slack);
      inside = std::move(parts.first);
      outside.push_back(std::move(parts.second));
    }
    if (outside.empty()) return false;
    add_polygon(inside, piece.bound, target);
    for (const Polygon& polygon : outside) add_polygon(polygon, piece.bound, target);
    return true;
  }

  void add_polygon(const Polygon& polygon, double bound, Index hint) {
    if (polygon.size() < 3) return;
    std::vector<Probe> probes;
    for (const Vec3& p : polygon) probes.push_back(look(p, hint));
    for (std::size_t i = 1; i + 1 < probes.size(); ++i) {
      Piece part;
      part.corner = {probes[0], probes[i], probes[i + 1]};
      add_above(part, bound, hint);
    }
  }

  /// As add(), but tries the triangle first above which the piece may lie.
  void add_above(Piece& part, double bound, Index triangle) {
    add(part, std::min(bound, bound_by(part, triangle)));
  }

  void halve(const Piece& piece) {
    const std::array<Probe, 3>& c = piece.corner;
    std::size_t longest = 0;
    double length = -1.0;
    for (std::size_t k = 0; k < 3; ++k) {
      const double side = length_sq(c[(k + 1) % 3].point - c[k].point);
      if (side <= length) continue;
      length = side;
      longest = k;
    }
    const Probe& a = c[longest];
    const Probe& b = c[(longest + 1) % 3];
    const Probe& apex = c[(longest + 2) % 3];
    const Probe half = look(0.5 * (a.point + b.point), piece.middle.nearest);
    Piece first;
    first.corner = {a, half, apex};
    add(first, piece.bound);
    Piece second;
    second.corner = {half, b, apex};
    add(second, piece.bound);
  }

  /// Relative to a piece's extent: what is cut off is at least so thick.
  static constexpr double kSlack = 1e-9;

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
  const Stars stars = build_stars(mesh);
  VertexLink link(mesh, stars);
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    link.move_to(static_cast<Index>(v));
    link.for_each_face([&](LinkFace face) {
      if (face.size() != 1 || link.vertex() > face[0].low) return;
      const Triangle t = link.outward_face(face[0]);
      if (std::all_of(t.begin(), t.end(), [&](Index i) { return is_finite(mesh.points[i]); })) {
        surface.triangles.push_back(t);
      }
    });
  }
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

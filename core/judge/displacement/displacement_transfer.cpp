#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "core/base/error.h"
#include "core/judge/displacement/displacement.h"
#include "core/judge/displacement/tet_tree.h"
#include "core/judge/mesh/tet_edges.h"
#include "core/judge/surface/surface.h"
#include "core/judge/surface/triangle_tree.h"

namespace palpate::judge {
namespace {

/// A point whose least barycentric coordinate is no less than this lies in the tet: rounding alone can make a
/// point on a common face miss both tets.
constexpr double kInside = -1e-12;

/// A point is not counted as outside if it is so by no more than this share of the box's diagonal.
constexpr double kRounding = 1e-12;

/// Barycentric coordinates of a point of a triangle.
using TriangleShares = std::array<double, 3>;

Vec3 blend(const Corners& t, const TriangleShares& share) {
  return share[0] * t.a + share[1] * t.b + share[2] * t.c;
}

/// The point of the segment a-b that is nearest to p, as the share of b.
double nearest_on_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 side = b - a;
  const double whole = length_sq(side);
  return whole > 0.0 ? std::clamp(dot(p - a, side) / whole, 0.0, 1.0) : 0.0;
}

/// The point of a closed triangle that is nearest to p.
TriangleShares nearest_on_triangle(const Vec3& p, const Corners& t) {
  const Vec3 normal = cross(t.b - t.a, t.c - t.a);
  const double area_sq = length_sq(normal);
  if (area_sq > 0.0) {
    const double of_b = dot(cross(p - t.a, t.c - t.a), normal) / area_sq;
    const double of_c = dot(cross(t.b - t.a, p - t.a), normal) / area_sq;
    if (of_b >= 0.0 && of_c >= 0.0 && of_b + of_c <= 1.0) return {1.0 - of_b - of_c, of_b, of_c};
  }
  const double ab = nearest_on_segment(p, t.a, t.b);
  const double bc = nearest_on_segment(p, t.b, t.c);
  const double ca = nearest_on_segment(p, t.c, t.a);
  const std::array<TriangleShares, 3> sides{{{1.0 - ab, ab, 0.0}, {0.0, 1.0 - bc, bc}, {ca, 0.0, 1.0 - ca}}};
  return *std::min_element(sides.begin(), sides.end(), [&](const auto& x, const auto& y) {
    return length_sq(p - blend(t, x)) < length_sq(p - blend(t, y));
  });
}

/// The point of the tet with the negative coordinates put to zero: in the tet, though not the nearest of it.
std::array<double, 4> pulled_inside(std::array<double, 4> share) {
  double sum = 0.0;
  for (double& s : share) sum += s = std::max(s, 0.0);
  for (double& s : share) s /= sum;
  return share;
}

class Transfer {
 public:
  Transfer(const TetMesh& source, std::span<const Vec3> field)
      : source_(source), field_(field), tets_(source), skin_(build_boundary(source)), triangles_(corners()) {
    if (field.size() == source.points.size()) return;
    edges_ = number_edges(source);
    require(field.size() == source.points.size() + edges_.edges.size(),
            "transfer_field: neither one value a vertex nor one a vertex and edge");
  }

  /// Value at p, and how far p lies outside (0 inside).
  std::pair<Vec3, double> at(const Vec3& p) const {
    const TetPlace place = tets_.find(p);
    if (place.least >= kInside) return {value_in_tet(place.tet, place.share), 0.0};
    const Nearest nearest = triangles_.nearest(p);
    const double skin_distance = std::sqrt(nearest.distance_sq);
    if (place.tet != kNoIndex) {  // between tets that rounding has parted: the nearest skin may be far away
      const std::array<double, 4> inside = pulled_inside(place.share);
      const double distance = length(p - in_tet(source_.points, place.tet, inside));
      if (distance < skin_distance) return {value_in_tet(place.tet, inside), distance};
    }
    const TriangleShares share = nearest_on_triangle(p, triangles_.triangle(nearest.triangle));
    return {value_on_face(skin_.triangles[nearest.triangle], share), skin_distance};
  }

 private:
  std::vector<Corners> corners() const {
    std::vector<Corners> all;
    all.reserve(skin_.triangles.size());
    for (const Triangle& t : skin_.triangles)
      all.push_back({skin_.points[t[0]], skin_.points[t[1]], skin_.points[t[2]]});
    return all;
  }

  Vec3 in_tet(std::span<const Vec3> values, Index t, const std::array<double, 4>& share) const {
    Vec3 sum;
    for (std::size_t i = 0; i < 4; ++i) sum = sum + share[i] * values[source_.tets[t][i]];
    return sum;
  }

  /// Linear shape functions b_i, or quadratic ones: b_i (2 b_i - 1) at the corners, 4 b_i b_j at midpoints.
  Vec3 value_in_tet(Index t, const std::array<double, 4>& share) const {
    if (edges_.edges.empty()) return in_tet(field_, t, share);
    Vec3 sum;
    for (std::size_t i = 0; i < 4; ++i)
      sum = sum + share[i] * (2.0 * share[i] - 1.0) * field_[source_.tets[t][i]];
    for (std::size_t k = 0; k < kTetEdges.size(); ++k) {
      const auto [i, j] = kTetEdges[k];
      const double bubble = 4.0 * share[static_cast<std::size_t>(i)] * share[static_cast<std::size_t>(j)];
      sum = sum + bubble * at_midpoint(edges_.of_tet[t][k]);
    }
    return sum;
  }

  Vec3 value_on_face(const Triangle& t, const TriangleShares& share) const {
    if (edges_.edges.empty()) return blend({field_[t[0]], field_[t[1]], field_[t[2]]}, share);
    Vec3 sum;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t j = (i + 1) % 3;
      const Edge ends{std::min(t[i], t[j]), std::max(t[i], t[j])};
      const auto place = std::lower_bound(edges_.edges.begin(), edges_.edges.end(), ends);
      sum = sum + share[i] * (2.0 * share[i] - 1.0) * field_[t[i]] +
            4.0 * share[i] * share[j] * at_midpoint(static_cast<Index>(place - edges_.edges.begin()));
    }
    return sum;
  }

  Vec3 at_midpoint(Index edge) const { return field_[source_.points.size() + edge]; }

  const TetMesh& source_;
  std::span<const Vec3> field_;
  TetEdges edges_;  // empty for fields that are linear in each tet
  TetTree tets_;
  SurfaceMesh skin_;
  TriangleTree triangles_;
};

}  // namespace

TransferredField transfer_field(const TetMesh& source, std::span<const Vec3> field,
                                std::span<const Vec3> points) {
  require(!source.tets.empty(), "transfer_field: a mesh without tetrahedra");
  for (const Tet& tet : source.tets)
    for (const Index v : tet)
      require(v < source.points.size(), "transfer_field: a tet has a vertex that does not exist");
  require_finite(source.points, "mesh of the displacement");
  require_finite(field, "displacement");
  require_finite(points, "points of the reference");
  const Transfer transfer(source, field);
  Box box;
  for (const Vec3& p : source.points) box.add(p);
  const double rounding = kRounding * length(box.high - box.low);
  TransferredField result;
  result.value.reserve(points.size());
  for (const Vec3& p : points) {
    const auto [value, distance] = transfer.at(p);
    result.value.push_back(value);
    if (distance > rounding) ++result.outside;
    result.farthest_outside = std::max(result.farthest_outside, distance);
  }
  return result;
}

}  // namespace palpate::judge

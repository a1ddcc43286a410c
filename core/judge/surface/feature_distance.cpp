#include "core/judge/surface/feature_distance.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <queue>

#include "core/base/error.h"
#include "core/judge/mesh/tet_shape.h"
#include "core/judge/surface/triangle_tree.h"

namespace palpate::judge {
namespace {

constexpr double kRelativeGap = 1e-3;
constexpr double kAbsoluteGap = 1e-7;  ///< of the diagonal

/// 0 to pi; 0 where one of the two is zero.
double angle_between(const Vec3& a, const Vec3& b) {
  return std::atan2(length(cross(a, b)), dot(a, b));
}

using EdgeNormals = std::map<std::pair<Index, Index>, std::vector<Vec3>>;

/// Of each edge the normals of its triangles, of any length.
EdgeNormals normals_by_edge(const SurfaceMesh& surface) {
  const int exponent = length_exponent(surface.points);
  const auto scaled = [&](Index v) {
    require(v < surface.points.size(), "edges of a surface: a triangle's vertex does not exist");
    const Vec3& p = surface.points[v];
    require(is_finite(p), "edges of a surface: a point is not finite");
    return Vec3{std::scalbn(p.x, -exponent), std::scalbn(p.y, -exponent), std::scalbn(p.z, -exponent)};
  };
  EdgeNormals normals_at;
  for (const Triangle& t : surface.triangles) {
    const Vec3 a = scaled(t[0]);
    const Vec3 normal = cross(scaled(t[1]) - a, scaled(t[2]) - a);
    for (std::size_t k = 0; k < 3; ++k) normals_at[std::minmax(t[k], t[(k + 1) % 3])].push_back(normal);
  }
  return normals_at;
}

/// Part of an edge, none of whose points is farther away than the bound.
struct EdgePart {
  EdgeEnds ends;
  double bound = 0.0;
  bool operator<(const EdgePart& other) const { return bound < other.bound; }
};

/// Edges as triangles without area, which is what the tree knows.
std::vector<Corners> as_triangles(const std::vector<EdgeEnds>& edges) {
  std::vector<Corners> triangles;
  triangles.reserve(edges.size());
  for (const auto& [a, b] : edges) triangles.push_back({a, b, b});
  return triangles;
}

class EdgeBracketing {
 public:
  EdgeBracketing(const TriangleTree& to, double absolute_gap) : to_(to), absolute_gap_(absolute_gap) {}

  EdgeDistance run(const std::vector<EdgeEnds>& from) {
    for (const EdgeEnds& edge : from) {
      for (const Vec3& p : edge) look(p);
    }
    for (const EdgeEnds& edge : from) add(edge);
    while (!open_.empty() && open_.top().bound > good_enough()) {
      const auto [p, q] = open_.top().ends;
      open_.pop();
      const Vec3 middle = 0.5 * (p + q);
      add({p, middle});
      add({middle, q});
    }
    return {lower_, std::max({lower_, settled_, open_.empty() ? 0.0 : open_.top().bound})};
  }

 private:
  double good_enough() const { return std::max(lower_ * (1.0 + kRelativeGap), lower_ + absolute_gap_); }

  Nearest look(const Vec3& p) {
    const Nearest found = to_.nearest(p);
    lower_ = std::max(lower_, std::sqrt(found.distance_sq));
    return found;
  }

  void add(const EdgeEnds& part) {
    const Nearest near = look(0.5 * (part[0] + part[1]));
    const Corners& b = to_.triangle(near.triangle);
    const double by_ends = std::sqrt(std::max(distance_sq(part[0], b), distance_sq(part[1], b)));
    const double by_middle = std::sqrt(near.distance_sq) + 0.5 * length(part[1] - part[0]);
    const double bound = std::min(by_ends, by_middle);
    if (bound <= good_enough()) {
      settled_ = std::max(settled_, bound);
    } else {
      open_.push({part, bound});
    }
  }

  const TriangleTree& to_;
  double absolute_gap_ = 0.0;
  double lower_ = 0.0;
  double settled_ = 0.0;
  std::priority_queue<EdgePart> open_;
};

}  // namespace

std::vector<EdgeEnds> list_sharp_edges(const SurfaceMesh& surface, double angle_deg) {
  std::vector<EdgeEnds> sharp;
  for (const auto& [ends, normals] : normals_by_edge(surface)) {
    if (normals.size() == 2 &&
        !(angle_between(normals[0], normals[1]) * 180.0 / std::numbers::pi > angle_deg))
      continue;
    sharp.push_back({surface.points[ends.first], surface.points[ends.second]});
  }
  return sharp;
}

double total_bend(const SurfaceMesh& surface) {
  double sum = 0.0;
  for (const auto& [ends, normals] : normals_by_edge(surface)) {
    if (normals.size() != 2) continue;
    sum += length(surface.points[ends.second] - surface.points[ends.first]) *
           angle_between(normals[0], normals[1]);
  }
  return sum;
}

EdgeDistance measure_edge_distance(const std::vector<EdgeEnds>& from, const std::vector<EdgeEnds>& to) {
  if (from.empty()) return {};
  if (to.empty()) {
    const double infinite = std::numeric_limits<double>::infinity();
    return {infinite, infinite};
  }
  std::vector<Vec3> ends;
  for (const auto* edges : {&from, &to}) {
    for (const EdgeEnds& edge : *edges) ends.insert(ends.end(), edge.begin(), edge.end());
  }
  const int exponent = length_exponent(ends);
  const auto scaled = [&](std::vector<EdgeEnds> edges) {
    for (EdgeEnds& edge : edges) {
      for (Vec3& p : edge)
        p = {std::scalbn(p.x, -exponent), std::scalbn(p.y, -exponent), std::scalbn(p.z, -exponent)};
    }
    return edges;
  };
  const std::vector<Corners> second = as_triangles(scaled(to));
  const std::vector<EdgeEnds> first = scaled(from);
  Box box;
  for (const Corners& t : second) box.add(t);
  for (const EdgeEnds& edge : first) {
    for (const Vec3& p : edge) box.add(p);
  }
  EdgeDistance result =
      EdgeBracketing(TriangleTree(second), kAbsoluteGap * length(box.high - box.low)).run(first);
  for (double* value : {&result.lower, &result.upper}) *value = std::scalbn(*value, exponent);
  return result;
}

FeatureDistance measure_feature_distance(const SurfaceMesh& input, const SurfaceMesh& output,
                                         double angle_deg) {
  require(angle_deg > 0.0 && angle_deg < 180.0, "feature distance: an angle from 0 to 180 degrees");
  const std::vector<EdgeEnds> before = list_sharp_edges(input, angle_deg);
  const std::vector<EdgeEnds> after = list_sharp_edges(output, 0.5 * angle_deg);
  return {before.size(), after.size(), measure_edge_distance(before, after)};
}

}  // namespace palpate::judge

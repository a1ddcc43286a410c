#include "core/simplify/sizing/triangle_tree.h"

#include <algorithm>
#include <cmath>

#include "core/base/component.h"
#include "core/base/error.h"

namespace palpate::simplify {
namespace {

constexpr std::size_t kLeafTriangles = 4;
constexpr std::size_t kDeepest = 64;  ///< halving 2^32 triangles takes 32 levels, and a level adds one entry

}  // namespace

double distance_sq_to_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 along = b - a;
  const double t = dot(p - a, along);
  if (!(t > 0.0)) return length_sq(p - a);
  const double whole = length_sq(along);
  if (t >= whole) return length_sq(p - b);
  return length_sq(p - a - (t / whole) * along);
}

double distance_sq_to_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 normal = cross(b - a, c - a);
  const bool within_ab = dot(cross(b - a, p - a), normal) > 0.0;
  const bool within_bc = dot(cross(c - b, p - b), normal) > 0.0;
  const bool within_ca = dot(cross(a - c, p - c), normal) > 0.0;
  if (within_ab && within_bc && within_ca) {
    const double height = dot(p - a, normal);
    return height * height / length_sq(normal);
  }
  // From outside a convex set, the nearest point is on a side that the point is beyond.
  double least = std::numeric_limits<double>::infinity();
  if (!within_ab) least = distance_sq_to_segment(p, a, b);
  if (!within_bc) least = std::min(least, distance_sq_to_segment(p, b, c));
  if (!within_ca) least = std::min(least, distance_sq_to_segment(p, c, a));
  return least;
}

double distance_sq_of_segments(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const Vec3 u = b - a;
  const Vec3 v = d - c;
  const Vec3 w = c - a;
  const Vec3 normal = cross(u, v);
  const double normal_sq = length_sq(normal);
  // The lines are nearest at a + s u and c + t v; if both lie inside, so are the segments.
  const double s = dot(cross(w, v), normal);
  const double t = dot(cross(w, u), normal);
  if (s > 0.0 && s < normal_sq && t > 0.0 && t < normal_sq) {
    const double height = dot(w, normal);
    return height * height / normal_sq;
  }
  return std::min({distance_sq_to_segment(a, c, d), distance_sq_to_segment(b, c, d),
                   distance_sq_to_segment(c, a, b), distance_sq_to_segment(d, a, b)});
}

double distance_sq_of_tet_and_triangle(const std::array<Vec3, 4>& tet, const std::array<Vec3, 3>& triangle) {
  double least = std::numeric_limits<double>::infinity();
  const auto take = [&](double distance_sq) { least = std::min(least, distance_sq); };
  for (const Vec3& p : tet) take(distance_sq_to_triangle(p, triangle[0], triangle[1], triangle[2]));
  for (const auto& [i, j, k] : kTetFaces) {
    for (const Vec3& p : triangle) take(distance_sq_to_triangle(p, tet[i], tet[j], tet[k]));
  }
  for (const auto& [i, j] : kTetEdges) {
    for (std::size_t e = 0; e < 3; ++e)
      take(distance_sq_of_segments(tet[i], tet[j], triangle[e], triangle[(e + 1) % 3]));
  }
  return least;
}

TriangleTree::TriangleTree(std::span<const Vec3> points, std::span<const Triangle> triangles) {
  if (triangles.empty()) throw InputError("the tree", 0, "a triangle or more", "none");
  corners_.reserve(triangles.size());
  for (const Triangle& t : triangles) corners_.push_back({points[t[0]], points[t[1]], points[t[2]]});
  build(0, corners_.size());
}

void TriangleTree::build(std::size_t first, std::size_t count) {
  const std::size_t at = nodes_.size();
  const std::span<std::array<Vec3, 3>> part{corners_.data() + first, count};
  const BoundingBox box = bounding_box({part.front().data(), 3 * count});
  nodes_.push_back({box, first, count, 0});
  if (count <= kLeafTriangles) return;
  const Vec3 size = box.high - box.low;
  const std::size_t axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const auto middle = [axis](const std::array<Vec3, 3>& t) { return component(t[0] + t[1] + t[2], axis); };
  const auto half = part.begin() + static_cast<std::ptrdiff_t>(count / 2);
  std::nth_element(part.begin(), half, part.end(),
                   [&](const auto& a, const auto& b) { return middle(a) < middle(b); });
  build(first, count / 2);
  nodes_[at].right = nodes_.size();
  build(first + count / 2, count - count / 2);
}

template <bool kAny>
TriangleTree::Nearest TriangleTree::search(const Vec3& p, double bound_sq) const {
  struct Entry {
    std::size_t node;
    double distance_sq;
  };
  Nearest found{nullptr, bound_sq};
  double& best = found.distance_sq;
  std::array<Entry, kDeepest> stack;
  std::size_t size = 0;
  const auto push = [&](std::size_t node, double distance_sq) {
    if (distance_sq < best) stack[size++] = {node, distance_sq};
  };
  push(0, distance_sq_to_box(p, nodes_[0].box));
  while (size > 0) {
    const Entry entry = stack[--size];
    if (entry.distance_sq >= best) continue;
    const Node& node = nodes_[entry.node];
    if (node.right == 0) {
      for (std::size_t i = node.first; i < node.first + node.count; ++i) {
        const double here = distance_sq_to_triangle(p, corners_[i][0], corners_[i][1], corners_[i][2]);
        if (here < best) found = {&corners_[i], here};
        if (kAny && found.triangle != nullptr) return found;
      }
      continue;
    }
    const double left = distance_sq_to_box(p, nodes_[entry.node + 1].box);
    const double right = distance_sq_to_box(p, nodes_[node.right].box);
    if (left < right) {  // the nearer one comes off the stack first
      push(node.right, right);
      push(entry.node + 1, left);
    } else {
      push(entry.node + 1, left);
      push(node.right, right);
    }
  }
  return found;
}

TriangleTree::Nearest TriangleTree::nearest(const Vec3& p, double bound_sq) const {
  return search<false>(p, bound_sq);
}

bool TriangleTree::is_below(const Vec3& p, double bound_sq) const {
  return search<true>(p, bound_sq).triangle != nullptr;
}

double TriangleTree::distance(const Vec3& p, double bound) const {
  const Nearest found = nearest(p, bound * bound);
  return found.triangle != nullptr ? std::sqrt(found.distance_sq) : bound;
}

bool TriangleTree::is_within(const std::array<Vec3, 4>& tet, double reach) const {
  const BoundingBox box = bounding_box(tet);
  const double reach_sq = reach * reach;
  std::array<std::size_t, kDeepest> stack;
  std::size_t size = 0;
  stack[size++] = 0;
  while (size > 0) {
    const std::size_t at = stack[--size];
    const Node& node = nodes_[at];
    if (distance_sq_of_boxes(box, node.box) > reach_sq) continue;
    if (node.right != 0) {
      stack[size++] = node.right;
      stack[size++] = at + 1;
      continue;
    }
    for (std::size_t i = node.first; i < node.first + node.count; ++i) {
      if (distance_sq_of_tet_and_triangle(tet, corners_[i]) <= reach_sq) return true;
    }
  }
  return false;
}

}  // namespace palpate::simplify

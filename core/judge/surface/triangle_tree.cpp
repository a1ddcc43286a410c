#include "core/judge/surface/triangle_tree.h"

#include <algorithm>
#include <numeric>
#include "core/base/component.h"

namespace palpate::judge {
namespace {

constexpr Index kLeafSize = 4;

double segment_distance_sq(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 side = b - a;
  const double length = length_sq(side);
  const double along = dot(p - a, side);
  if (along <= 0.0 || length == 0.0) return length_sq(p - a);
  if (along >= length) return length_sq(p - b);
  return length_sq(p - (a + (along / length) * side));
}

}  // namespace

void Box::add(const Vec3& p) {
  low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
  high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
}

void Box::add(const Corners& t) {
  add(t.a);
  add(t.b);
  add(t.c);
}

double Box::distance_sq(const Vec3& p) const {
  const Vec3 gap{std::max({low.x - p.x, 0.0, p.x - high.x}), std::max({low.y - p.y, 0.0, p.y - high.y}),
                 std::max({low.z - p.z, 0.0, p.z - high.z})};
  return length_sq(gap);
}

double distance_sq(const Vec3& p, const Corners& t) {
  const Vec3 normal = cross(t.b - t.a, t.c - t.a);
  const double area_sq = length_sq(normal);
  const bool above = area_sq > 0.0 && dot(cross(t.b - t.a, p - t.a), normal) >= 0.0 &&
                     dot(cross(t.c - t.b, p - t.b), normal) >= 0.0 &&
                     dot(cross(t.a - t.c, p - t.c), normal) >= 0.0;
  if (above) {
    const double height = dot(p - t.a, normal);
    return height * height / area_sq;
  }
  return std::min(
      {segment_distance_sq(p, t.a, t.b), segment_distance_sq(p, t.b, t.c), segment_distance_sq(p, t.c, t.a)});
}

TriangleTree::TriangleTree(std::span<const Corners> triangles) {
  const auto count = static_cast<Index>(triangles.size());
  number_.resize(count);
  std::iota(number_.begin(), number_.end(), Index{0});
  triangles_.assign(triangles.begin(), triangles.end());  // by number, while the tree is built
  if (count > 0) {
    nodes_.reserve(count);
    nodes_.emplace_back();
    build(0, 0, count);
  }
  place_.resize(count);
  boxes_.resize(count);
  for (Index k = 0; k < count; ++k) {
    triangles_[k] = triangles[number_[k]];
    place_[number_[k]] = k;
    boxes_[k].add(triangles_[k]);
  }
}

// Depth: log2 of the number of triangles, for each half has at most half of them, rounded up.
void TriangleTree::build(Index node, Index begin, Index end) {
  Box box;
  Box centers;  // of three times the centroids
  for (Index k = begin; k < end; ++k) {
    const Corners& t = triangles_[number_[k]];
    box.add(t);
    centers.add(t.a + t.b + t.c);
  }
  nodes_[node].box = box;
  if (end - begin <= kLeafSize) {
    nodes_[node].first = begin;
    nodes_[node].count = end - begin;
    return;
  }
  const std::size_t axis = centers.longest_axis();
  const Index middle = begin + (end - begin) / 2;
  std::nth_element(number_.begin() + begin, number_.begin() + middle, number_.begin() + end,
                   [&](Index i, Index j) {
                     const Corners& s = triangles_[i];
                     const Corners& t = triangles_[j];
                     const double x = component(s.a + s.b + s.c, axis);
                     const double y = component(t.a + t.b + t.c, axis);
                     return x != y ? x < y : i < j;
                   });
  const auto child = static_cast<Index>(nodes_.size());
  nodes_[node].first = child;
  nodes_.emplace_back();
  nodes_.emplace_back();
  build(child, begin, middle);
  build(child + 1, middle, end);
}

Nearest TriangleTree::nearest(const Vec3& p, Index hint) const {
  Nearest best;
  if (hint != kNoIndex) best = {hint, judge::distance_sq(p, triangle(hint))};
  struct Entry {
    Index node;
    double distance_sq;
  };
  std::array<Entry, kStackSize> stack;
  std::size_t size = 0;
  stack[size++] = {0, nodes_[0].box.distance_sq(p)};
  while (size > 0) {
    const Entry entry = stack[--size];
    if (entry.distance_sq >= best.distance_sq) continue;
    const Node& node = nodes_[entry.node];
    for (Index k = node.first; k < node.first + node.count; ++k) {
      const double found = judge::distance_sq(p, triangles_[k]);
      if (found < best.distance_sq) best = {number_[k], found};
    }
    if (node.count > 0) continue;
    Entry near{node.first, nodes_[node.first].box.distance_sq(p)};
    Entry far{node.first + 1, nodes_[node.first + 1].box.distance_sq(p)};
    if (far.distance_sq < near.distance_sq) std::swap(near, far);
    stack[size++] = far;
    stack[size++] = near;
  }
  return best;
}

}  // namespace palpate::judge

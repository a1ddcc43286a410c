#include "core/judge/displacement/tet_tree.h"

#include <algorithm>
#include <numeric>
#include "core/base/component.h"

namespace palpate::judge {
namespace {

constexpr Index kLeafSize = 4;
constexpr std::size_t kStackSize = 64;  // one node waits for each of the at most 32 levels

bool holds(const Box& box, const Vec3& p) {
  return p.x >= box.low.x && p.x <= box.high.x && p.y >= box.low.y && p.y <= box.high.y && p.z >= box.low.z &&
         p.z <= box.high.z;
}

/// Barycentric coordinates of p by Cramer's rule.
TetPlace place_in(const TetMesh& mesh, Index t, const Vec3& p) {
  const Tet& tet = mesh.tets[t];
  const Vec3& o = mesh.points[tet[0]];
  const Vec3 a = mesh.points[tet[1]] - o;
  const Vec3 b = mesh.points[tet[2]] - o;
  const Vec3 c = mesh.points[tet[3]] - o;
  const Vec3 r = p - o;
  TetPlace place;
  const double whole = dot(cross(a, b), c);
  if (whole == 0.0) return place;
  place.tet = t;
  place.share[1] = dot(cross(b, c), r) / whole;
  place.share[2] = dot(cross(c, a), r) / whole;
  place.share[3] = dot(cross(a, b), r) / whole;
  place.share[0] = 1.0 - place.share[1] - place.share[2] - place.share[3];
  place.least = *std::min_element(place.share.begin(), place.share.end());
  return place;
}

}  // namespace

TetTree::TetTree(const TetMesh& mesh) : mesh_(mesh) {
  const auto count = static_cast<Index>(mesh.tets.size());
  number_.resize(count);
  std::iota(number_.begin(), number_.end(), Index{0});
  if (count == 0) return;
  std::vector<Vec3> centers(count);  // four times the centroids
  for (Index t = 0; t < count; ++t)
    for (const Index v : mesh.tets[t]) centers[t] = centers[t] + mesh.points[v];
  nodes_.reserve(count);
  nodes_.emplace_back();
  build(0, 0, count, centers);
}

void TetTree::build(Index node, Index begin, Index end, const std::vector<Vec3>& centers) {
  Box box;
  if (end - begin <= kLeafSize) {
    for (Index k = begin; k < end; ++k)
      for (const Index v : mesh_.tets[number_[k]]) box.add(mesh_.points[v]);
    nodes_[node] = {box, begin, end - begin};
    return;
  }
  Box middle_points;
  for (Index k = begin; k < end; ++k) middle_points.add(centers[number_[k]]);
  const std::size_t axis = middle_points.longest_axis();
  const Index middle = begin + (end - begin) / 2;
  std::nth_element(number_.begin() + begin, number_.begin() + middle, number_.begin() + end,
                   [&](Index i, Index j) {
                     const double x = component(centers[i], axis);
                     const double y = component(centers[j], axis);
                     return x != y ? x < y : i < j;
                   });
  const auto child = static_cast<Index>(nodes_.size());
  nodes_.emplace_back();
  nodes_.emplace_back();
  build(child, begin, middle, centers);
  build(child + 1, middle, end, centers);
  box = nodes_[child].box;
  box.add(nodes_[child + 1].box.low);
  box.add(nodes_[child + 1].box.high);
  nodes_[node] = {box, child, 0};
}

TetPlace TetTree::find(const Vec3& p) const {
  TetPlace best;
  if (nodes_.empty()) return best;
  std::array<Index, kStackSize> stack{};
  std::size_t size = 1;
  while (size > 0) {
    const Node& node = nodes_[stack[--size]];
    if (!holds(node.box, p)) continue;
    if (node.count == 0) {
      stack[size++] = node.first + 1;
      stack[size++] = node.first;
      continue;
    }
    for (Index k = node.first; k < node.first + node.count; ++k) {
      const TetPlace place = place_in(mesh_, number_[k], p);
      if (place.least > best.least) best = place;
      if (best.least >= 0.0) return best;
    }
  }
  return best;
}

}  // namespace palpate::judge

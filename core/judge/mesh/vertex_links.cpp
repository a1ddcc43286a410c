#include "core/judge/mesh/vertex_links.h"

#include <algorithm>
#include <numeric>

namespace palpate::judge {

bool has_valid_indices(const Tet& tet, std::size_t points) {
  for (std::size_t i = 0; i < tet.size(); ++i) {
    if (tet[i] >= points) return false;
    for (std::size_t j = 0; j < i; ++j) {
      if (tet[i] == tet[j]) return false;
    }
  }
  return true;
}

Stars build_stars(const TetMesh& mesh) {
  const std::size_t points = mesh.points.size();
  Stars stars;
  stars.offsets.assign(points + 1, 0);
  for (const Tet& tet : mesh.tets) {
    if (!has_valid_indices(tet, points)) continue;
    for (const Index v : tet) ++stars.offsets[v];
  }
  std::size_t total = 0;  // offsets become the ends of the rows, and their starts as the rows fill backwards
  for (std::size_t& offset : stars.offsets) {
    total += offset;
    offset = total;
  }
  stars.tets.resize(total);
  for (std::size_t t = mesh.tets.size(); t-- > 0;) {
    if (!has_valid_indices(mesh.tets[t], points)) continue;
    for (const Index v : mesh.tets[t]) stars.tets[--stars.offsets[v]] = static_cast<Index>(t);
  }
  return stars;
}

VertexLink::VertexLink(const TetMesh& mesh, const Stars& stars)
    : mesh_(&mesh), stars_(&stars), seen_at_(mesh.points.size(), 0) {}

void VertexLink::move_to(Index vertex) {
  vertex_ = vertex;
  ++visit_;
  star_ = stars_->of(vertex);
  corners_.clear();
  sides_.clear();
  vertices_.clear();
  for (std::size_t position = 0; position < star_.size(); ++position) {
    const Index t = star_[position];
    const Tet& tet = mesh_->tets[t];
    std::size_t apex = 0;
    while (tet[apex] != vertex) ++apex;
    Triangle corner{};
    for (std::size_t k = 0; k < 3; ++k) corner[k] = tet[static_cast<std::size_t>(kTetFaces[apex][k])];
    corners_.push_back(corner);
    for (std::size_t k = 0; k < 3; ++k) {
      const Index from = corner[k];
      const Index to = corner[(k + 1) % 3];
      sides_.push_back({std::min(from, to), std::max(from, to), t, static_cast<Index>(position), from < to});
      if (seen_at_[from] != visit_) {
        seen_at_[from] = visit_;
        vertices_.push_back(from);
      }
    }
  }
  std::sort(sides_.begin(), sides_.end(), [](const LinkSide& a, const LinkSide& b) {
    if (a.low != b.low) return a.low < b.low;
    return a.high != b.high ? a.high < b.high : a.tet < b.tet;
  });
}

void DisjointSets::reset(std::size_t size) {
  parent_.resize(size);
  std::iota(parent_.begin(), parent_.end(), Index{0});
}

Index DisjointSets::root(Index item) {
  while (parent_[item] != item) {
    parent_[item] = parent_[parent_[item]];
    item = parent_[item];
  }
  return item;
}

bool DisjointSets::join(Index a, Index b) {
  const Index root_a = root(a);
  const Index root_b = root(b);
  if (root_a == root_b) return false;
  parent_[std::max(root_a, root_b)] = std::min(root_a, root_b);
  return true;
}

}  // namespace palpate::judge

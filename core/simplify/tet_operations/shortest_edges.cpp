#include "core/simplify/tet_operations/shortest_edges.h"

#include <algorithm>

namespace palpate::simplify {
namespace {

/// Each further batch is so many times as large as the one before, so that the mesh is walked a few times at
/// most.
constexpr std::size_t kGrowth = 8;

/// The order of std heaps is that of sizes turned round: the edge that comes first is the greatest.
bool comes_before(const WaitingEdge& a, const WaitingEdge& b) {
  return b < a;
}

}  // namespace

void collect_neighbours(const WorkingMesh& mesh, Index v, VertexMarks& marks, std::vector<Index>& neighbours,
                        Index least) {
  marks.clear(mesh.points.size());
  marks.set(v, 1);
  neighbours.clear();
  for (const Index t : mesh.star(v)) {
    for (const Index w : mesh.tets[t]) {
      if (w < least || marks.of(w) != 0) continue;
      marks.set(w, 1);
      neighbours.push_back(w);
    }
  }
}

ShortestEdges::ShortestEdges(const WorkingMesh& mesh, const SizingField& field, std::size_t first_batch)
    : mesh_(mesh), field_(field), batch_(first_batch), last_(mesh.points.size(), 0) {}

WaitingEdge ShortestEdges::edge_between(Index a, Index b) const {
  if (last_[a] != last_[b] ? last_[a] < last_[b] : b < a) std::swap(a, b);
  return {key_of_edge(mesh_, field_, a, b), a, b, last_[a] + last_[b]};
}

/// Keeps the first `count` of those that wait; the others are in the mesh.
void ShortestEdges::keep_first(std::size_t count) {
  const auto last = waiting_.begin() + static_cast<std::ptrdiff_t>(count) - 1;
  std::nth_element(waiting_.begin(), last, waiting_.end(), comes_before);
  bound_ = *last;
  waiting_.erase(last + 1, waiting_.end());
}

/// The first edges behind `bound_`, a batch of them. Returns whether there were any.
bool ShortestEdges::fill() {
  if (is_complete_) return false;
  const std::optional<WaitingEdge> before = bound_;
  is_complete_ = true;
  waiting_.clear();
  for (Index a = 0; a < mesh_.points.size(); ++a) {
    if (!mesh_.is_vertex_alive(a)) continue;
    collect_neighbours(mesh_, a, marks_, neighbours_, a + 1);
    for (const Index b : neighbours_) {
      if (!mesh_.is_free(a) && !mesh_.is_free(b)) continue;
      const WaitingEdge edge = edge_between(a, b);
      if (before && !comes_before(*before, edge)) continue;
      if (!is_complete_ && !comes_before(edge, *bound_)) continue;
      waiting_.push_back(edge);
      if (waiting_.size() < 2 * batch_) continue;
      keep_first(batch_);
      is_complete_ = false;
    }
  }
  if (waiting_.size() > batch_) {
    keep_first(batch_);
    is_complete_ = false;
  }
  batch_ *= kGrowth;
  std::make_heap(waiting_.begin(), waiting_.end());
  return !waiting_.empty();
}

std::optional<WaitingEdge> ShortestEdges::pop() {
  do {
    while (!waiting_.empty()) {
      std::pop_heap(waiting_.begin(), waiting_.end());
      const WaitingEdge edge = waiting_.back();
      waiting_.pop_back();
      if (!is_void(edge)) return edge;
    }
  } while (fill());
  return std::nullopt;
}

void ShortestEdges::start_over() {
  waiting_.swap(parked_);
  parked_.clear();
  is_complete_ = true;
  std::make_heap(waiting_.begin(), waiting_.end());
}

void ShortestEdges::drop_void() {
  std::erase_if(waiting_, [&](const WaitingEdge& edge) { return is_void(edge); });
  std::make_heap(waiting_.begin(), waiting_.end());
  if (2 * waiting_.size() > waiting_.capacity()) waiting_.reserve(2 * waiting_.capacity());
}

void ShortestEdges::renew(Index gone, Index survivor) {
  last_[gone] = last_[survivor] = ++collapses_;
  collect_neighbours(mesh_, survivor, marks_, neighbours_);
  for (const Index w : neighbours_) {
    if (!mesh_.is_free(survivor) && !mesh_.is_free(w)) continue;
    const WaitingEdge edge = edge_between(survivor, w);
    if (!is_complete_ && comes_before(*bound_, edge)) continue;
    if (waiting_.size() == waiting_.capacity()) drop_void();
    waiting_.push_back(edge);
    std::push_heap(waiting_.begin(), waiting_.end());
  }
}

}  // namespace palpate::simplify

// The edges that wait to be collapsed, the shortest first.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/base/types.h"
#include "core/simplify/tet_operations/working_mesh.h"

namespace palpate::simplify {

/// An edge that waits, with the versions of its ends when it was entered: older entries are void.
struct WaitingEdge {
  double key;
  Index a;
  Index b;
  std::uint32_t versions;
  std::uint32_t refused_at = 0;  ///< of StarChanges; 0 when it is entered
  std::uint32_t level = 0;       ///< for callers: the first at which it is worth a try again, unchanged

  /// Makes std heaps give the smallest key first; ties by vertex numbers.
  friend bool operator<(const WaitingEdge& l, const WaitingEdge& r) {
    if (l.key != r.key) return l.key > r.key;
    return l.a != r.a ? l.a > r.a : l.b > r.b;
  }
};

/// What edges are ordered by: squared length over the square of the relative size wanted at their middle.
inline double key_of_edge(const WorkingMesh& mesh, const SizingField& field, Index a, Index b) {
  const double key = length_sq(mesh.points[b] - mesh.points[a]);
  if (field.is_empty()) return key;
  const double size = field.relative_size(0.5 * (mesh.points[a] + mesh.points[b]));
  return key / (size * size);
}

/// Which edges that were refused have to be looked at again: the others would be refused for the same reason.
class StarChanges {
 public:
  explicit StarChanges(std::size_t vertices) : changed_at_(vertices, 0) {}

  /// To be called after a change: the stars of all corners of the tets around v are others now.
  void note(const WorkingMesh& mesh, Index v) {
    ++changes_;
    for (const Index t : mesh.star(v)) {
      for (const Index corner : mesh.tets[t]) changed_at_[corner] = changes_;
    }
  }

  /// To be called when an edge is refused.
  void mark_refused(WaitingEdge& edge) const { edge.refused_at = changes_ + 1; }

  /// Whether an end's star has changed since the edge was refused, or it never was.
  bool has_changed_since(const WaitingEdge& edge) const {
    return edge.refused_at == 0 || std::max(changed_at_[edge.a], changed_at_[edge.b]) >= edge.refused_at;
  }

 private:
  std::uint32_t changes_ = 0;
  std::vector<std::uint32_t> changed_at_;  ///< number of the last change of the vertex's star
};

/// A heap of edges by squared length over the square of the relative size wanted at their middle. An edge is
/// void once an end of it was renewed; one that was refused is parked until the heap starts over.
class EdgeHeap {
 public:
  explicit EdgeHeap(const WorkingMesh& mesh, const SizingField& field)
      : mesh_(mesh), field_(field), versions_(mesh.points.size(), 0) {}

  void reserve(std::size_t edges) { waiting_.reserve(edges); }

  /// Adds without order; heapify() has to follow.
  void append(Index a, Index b) {
    waiting_.push_back({key_of_edge(mesh_, field_, a, b), a, b, versions_of(a, b)});
  }
  void heapify() { std::make_heap(waiting_.begin(), waiting_.end()); }

  void push(Index a, Index b) {
    append(a, b);
    std::push_heap(waiting_.begin(), waiting_.end());
  }

  /// Removes and returns the shortest edge that is not void, or nothing.
  std::optional<WaitingEdge> pop() {
    while (!waiting_.empty()) {
      std::pop_heap(waiting_.begin(), waiting_.end());
      const WaitingEdge edge = waiting_.back();
      waiting_.pop_back();
      if (edge.versions == versions_of(edge.a, edge.b)) return edge;
    }
    return std::nullopt;
  }

  void park(const WaitingEdge& edge) { parked_.push_back(edge); }

  /// The parked edges wait again; what else waited is dropped.
  void start_over() {
    waiting_.swap(parked_);
    parked_.clear();
    heapify();
  }

  /// Makes all edges of v that wait void.
  void renew(Index v) { ++versions_[v]; }

 private:
  /// Both versions only ever grow, so their sum tells whether either has.
  std::uint32_t versions_of(Index a, Index b) const { return versions_[a] + versions_[b]; }

  const WorkingMesh& mesh_;
  const SizingField& field_;
  std::vector<std::uint32_t> versions_;
  std::vector<WaitingEdge> waiting_;
  std::vector<WaitingEdge> parked_;
};

}  // namespace palpate::simplify

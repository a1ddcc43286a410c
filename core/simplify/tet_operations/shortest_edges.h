// The edges inside a mesh, the shortest first, as few at a time as are needed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/simplify/tet_operations/edge_heap.h"
#include "core/simplify/tet_operations/working_mesh.h"

namespace palpate::simplify {

/// The vertices from number `least` on that share a tet with v, each once, in the order in which its star
/// meets them; marks them and v with 1.
void collect_neighbours(const WorkingMesh& mesh, Index v, VertexMarks& marks, std::vector<Index>& neighbours,
                        Index least = 0);

/// Gives a mesh's edges with at least one free end in the order of EdgeHeap, while edges are collapsed. It
/// holds the first of them only: the others are found again in the mesh, once these are used up. An edge is
/// oriented: the smaller number first, but once an end has become another edge's survivor, the last survivor
/// first.
///
/// Memory: 32 bytes an edge that it holds or that is parked, 8 a vertex.
class ShortestEdges {
 public:
  /// Begins with about `first_batch` edges. Holds references.
  ShortestEdges(const WorkingMesh& mesh, const SizingField& field, std::size_t first_batch);

  /// Removes and returns the shortest edge, or nothing if all are gone or parked.
  std::optional<WaitingEdge> pop();

  /// Sets an edge aside until start_over().
  void park(const WaitingEdge& edge) { parked_.push_back(edge); }

  /// The parked edges wait again, and those of later collapses; what else waited is dropped.
  void start_over();

  /// To be called after a collapse: the edges of both ends are void, those of the survivor wait anew.
  void renew(Index gone, Index survivor);

 private:
  bool fill();
  double estimate_limit() const;
  void take_from_tets(double limit);
  void take_from_stars(double limit);
  void take(const WaitingEdge& edge);
  void keep_first(std::size_t count);
  void drop_void();
  WaitingEdge edge_between(Index a, Index b) const;
  bool may_collapse(Index a, Index b) const { return mesh_.is_free(a) || mesh_.is_free(b); }
  bool is_void(const WaitingEdge& edge) const { return edge.versions != last_[edge.a] + last_[edge.b]; }

  const WorkingMesh& mesh_;
  const SizingField& field_;
  std::size_t batch_;
  std::uint32_t collapses_ = 0;
  std::vector<std::uint32_t> last_;   ///< number of the last collapse that the vertex was an end of, or 0
  std::vector<WaitingEdge> waiting_;  ///< a heap
  std::vector<WaitingEdge> parked_;
  std::optional<WaitingEdge> before_;  ///< a batch that is looked for comes behind it
  std::optional<WaitingEdge> bound_;   ///< what comes behind it is in the mesh alone
  bool is_complete_ = false;           ///< nothing comes behind `bound_`
  std::vector<Index> neighbours_;
  VertexMarks marks_;
};

}  // namespace palpate::simplify

#include "core/simplify/surface/surface_split.h"

#include <algorithm>
#include <tuple>
#include <vector>

#include "core/mesh/orientation.h"
#include "core/simplify/tet_operations/edge_heap.h"

namespace palpate::simplify {
namespace {

struct LongEdge {
  double key;  ///< see key_of_edge
  Index a;     ///< a < b
  Index b;
};

/// The boundary edges that are longer than wanted and on no feature line, the longest first.
std::vector<LongEdge> collect_long_edges(const WorkingMesh& mesh, const GuardedBoundary& boundary,
                                         const SizingField& field, double shortest) {
  std::vector<LongEdge> edges;
  boundary.for_each_edge([&](Index a, Index b) {
    const double key = key_of_edge(mesh, field, a, b);
    if (key > shortest * shortest && !boundary.lines().is_line(a, b)) edges.push_back({key, a, b});
  });
  std::sort(edges.begin(), edges.end(), [](const LongEdge& x, const LongEdge& y) {
    return std::tuple(-x.key, x.a, x.b) < std::tuple(-y.key, y.a, y.b);
  });
  return edges;
}

class BoundarySplitter {
 public:
  BoundarySplitter(WorkingMesh& mesh, GuardedBoundary& boundary, const ScoreRule& scores,
                   const SurfaceSplitOptions& options)
      : mesh_(mesh), boundary_(boundary), scores_(scores), options_(options) {}

  bool try_split(Index a, Index b) {
    collect_edge_star(mesh_, a, b, old_);
    if (old_.empty() || mesh_.alive + old_.size() > options_.most_tets) return false;
    if (std::any_of(old_.begin(), old_.end(), [&](Index t) { return mesh_.is_kept(t); })) return false;
    const Index middle = add_vertex(mesh_, 0.5 * (mesh_.points[a] + mesh_.points[b]));
    plan(a, b, middle);
    if (change_.removed.size() != 2 || !are_well_shaped(middle) ||
        boundary_.check(mesh_, change_) != BoundaryVerdict::kAllowed) {
      remove_vertex(mesh_, middle);
      return false;
    }
    boundary_.apply(change_);
    mesh_.vertex_flags[middle] = kOnBoundary;
    apply_flip(mesh_, old_, fresh_, added_);
    return true;
  }

 private:
  void plan(Index a, Index b, Index middle) {
    const auto with_middle_for = [middle](auto corners, Index gone) {
      std::replace(corners.begin(), corners.end(), gone, middle);
      return corners;
    };
    fresh_.clear();
    for (const Index t : old_) {
      for (const Index gone : {a, b}) fresh_.push_back(with_middle_for(mesh_.tets[t], gone));
    }
    change_.removed.clear();
    change_.fresh.clear();
    for (const Index f : boundary_.faces_of(a)) {
      if (!has_corner(boundary_.face(f), b)) continue;
      change_.removed.push_back(f);
      for (const Index gone : {a, b}) change_.fresh.push_back(with_middle_for(boundary_.face(f), gone));
    }
  }

  bool are_well_shaped(Index middle) const {
    const std::vector<Vec3>& p = mesh_.points;
    const ScoreScale scale = scores_.at(p[middle]);
    return std::all_of(fresh_.begin(), fresh_.end(), [&](const Tet& t) {
      return double{score_tet(scale, p[t[0]], p[t[1]], p[t[2]], p[t[3]])} > options_.least_score &&
             orientation(p[t[0]], p[t[1]], p[t[2]], p[t[3]]) > 0;
    });
  }

  WorkingMesh& mesh_;
  GuardedBoundary& boundary_;
  const ScoreRule& scores_;
  const SurfaceSplitOptions& options_;
  BoundaryChange change_;
  std::vector<Index> old_;
  std::vector<Tet> fresh_;
  std::vector<Index> added_;
};

}  // namespace

std::uint64_t split_boundary_edges(WorkingMesh& mesh, GuardedBoundary& boundary, const ScoreRule& scores,
                                   const SurfaceSplitOptions& options) {
  BoundarySplitter splitter(mesh, boundary, scores, options);
  std::uint64_t splits = 0;
  for (const LongEdge& edge : collect_long_edges(mesh, boundary, scores.field(), options.shortest)) {
    if (boundary.size() >= options.face_target || mesh.alive >= options.tet_target) break;
    if (splitter.try_split(edge.a, edge.b)) ++splits;
  }
  return splits;
}

}  // namespace palpate::simplify

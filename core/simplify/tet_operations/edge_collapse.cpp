#include "core/simplify/tet_operations/edge_collapse.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include "core/simplify/tet_operations/cone.h"

namespace palpate::simplify {
namespace {

/// An edge that waits, with the versions of its ends when it was entered: older entries are void.
struct Candidate {
  double key;
  Index a;
  Index b;
  std::uint32_t versions;

  /// Makes std heaps give the smallest key first; ties by vertex numbers.
  friend bool operator<(const Candidate& l, const Candidate& r) {
    if (l.key != r.key) return l.key > r.key;
    return l.a != r.a ? l.a > r.a : l.b > r.b;
  }
};

class Collapser {
 public:
  Collapser(WorkingMesh& mesh, const ScoreRule& rule, const CollapseOptions& options)
      : mesh_(mesh), rule_(rule), options_(options), versions_(mesh.points.size(), 0) {}

  CollapseReport run() {
    enter_all();
    std::uint64_t before = 0;
    do {
      before = report_.collapses;
      empty_heap();
      heap_.swap(parked_);  // what was refused is looked at again, as stars have changed
      parked_.clear();
      std::make_heap(heap_.begin(), heap_.end());
    } while (mesh_.alive > options_.target && report_.collapses > before);
    return report_;
  }

 private:
  void enter_all() {
    heap_.reserve(8 * mesh_.points.size());
    for (Index a = 0; a < mesh_.points.size(); ++a) {
      if (!mesh_.is_vertex_alive(a)) continue;
      collect_neighbours(a);
      for (const Index b : neighbours_) {
        if (a < b && (mesh_.is_free(a) || mesh_.is_free(b))) heap_.push_back({key_of(a, b), a, b, 0});
      }
    }
    std::make_heap(heap_.begin(), heap_.end());
  }

  void empty_heap() {
    while (mesh_.alive > options_.target && !heap_.empty()) {
      std::pop_heap(heap_.begin(), heap_.end());
      const Candidate c = heap_.back();
      heap_.pop_back();
      if (c.versions == versions_of(c.a, c.b) && !try_collapse(c.a, c.b)) parked_.push_back(c);
    }
  }

  /// Both versions only ever grow, so their sum tells whether either has.
  std::uint32_t versions_of(Index a, Index b) const { return versions_[a] + versions_[b]; }

  double key_of(Index a, Index b) const {
    const double key = length_sq(mesh_.points[b] - mesh_.points[a]);
    if (rule_.field().is_empty()) return key;
    const double size = rule_.field().relative_size(0.5 * (mesh_.points[a] + mesh_.points[b]));
    return key / (size * size);
  }

  void collect_neighbours(Index v) {
    marks_.clear(mesh_.points.size());
    marks_.set(v, 1);
    neighbours_.clear();
    for (const Index t : mesh_.star(v)) {
      for (const Index w : mesh_.tets[t]) {
        if (marks_.of(w) != 0) continue;
        marks_.set(w, 1);
        neighbours_.push_back(w);
      }
    }
  }

  /// Mean of the cone's base vertices, counted as often as they occur.
  Vec3 link_centroid(Index gone, Index kept) {
    Vec3 sum{};
    std::size_t count = 0;
    for (const Index center : {gone, kept}) {
      collect_neighbours(center);
      for (const Index v : neighbours_) {
        if (v != gone && v != kept) sum = sum + mesh_.points[v];
      }
      count += neighbours_.size() - 1;
    }
    return (1.0 / static_cast<double>(count)) * sum;
  }

  /// Whether there is a place where all tets are good enough; `place_` is set to it.
  bool find_place(Index gone, Index kept) {
    const Vec3 at_gone = mesh_.points[gone];
    const Vec3 at_kept = mesh_.points[kept];
    if (!mesh_.is_free(kept)) return try_place(at_kept, options_.least_score) > options_.least_score;
    double best = try_place(0.5 * (at_gone + at_kept), options_.least_score);
    const bool passes = best > options_.least_score;
    if (options_.placement == CollapsePlacement::kMidpoint) return passes;
    if (options_.placement == CollapsePlacement::kFirst && passes) return true;
    for (const Vec3& place : {link_centroid(gone, kept), at_kept, at_gone}) {
      best = try_place(place, best);
      if (options_.placement == CollapsePlacement::kFirst && best > options_.least_score) return true;
    }
    return best > options_.least_score;
  }

  /// The larger of `best` and the worst score with the apex at `place`, which is taken if that is larger.
  double try_place(const Vec3& place, double best) {
    const double worst = cone_.evaluate(place, best).worst;
    if (!(worst > best)) return best;
    place_ = place;
    return worst;
  }

  bool try_collapse(Index a, Index b) {
    Index gone = a;
    Index kept = b;
    if (!mesh_.is_free(gone)) std::swap(gone, kept);
    cone_.start(rule_.at(mesh_.points[kept]), mesh_.points[kept]);
    add_star(mesh_, gone, kept, cone_);
    if (mesh_.is_free(kept)) add_star(mesh_, kept, gone, cone_);
    if (cone_.size() == 0) return false;
    cone_.close();
    if (!find_place(gone, kept) || !cone_.is_positive(place_)) {
      ++report_.rejected_shape;
      return false;
    }
    if (!meets_link_condition(mesh_, gone, kept, marks_)) {
      ++report_.rejected_link;
      return false;
    }
    apply_collapse(mesh_, gone, kept, place_);
    ++report_.collapses;
    ++versions_[kept];
    ++versions_[gone];
    collect_neighbours(kept);
    for (const Index w : neighbours_) enter(kept, w);
    return true;
  }

  void enter(Index a, Index b) {
    if (!mesh_.is_free(a) && !mesh_.is_free(b)) return;
    heap_.push_back({key_of(a, b), a, b, versions_of(a, b)});
    std::push_heap(heap_.begin(), heap_.end());
  }

  WorkingMesh& mesh_;
  const ScoreRule& rule_;
  const CollapseOptions& options_;
  CollapseReport report_;
  std::vector<std::uint32_t> versions_;
  std::vector<Candidate> heap_;
  std::vector<Candidate> parked_;
  std::vector<Index> neighbours_;
  VertexMarks marks_;
  Cone cone_;
  Vec3 place_;
};

}  // namespace

CollapseReport collapse_edges(WorkingMesh& mesh, const ScoreRule& rule, const CollapseOptions& options) {
  return Collapser(mesh, rule, options).run();
}

}  // namespace palpate::simplify

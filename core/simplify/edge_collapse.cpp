#include "core/simplify/edge_collapse.h"

#include <algorithm>
#include <array>
#include <bit>
#include <utility>
#include <vector>

#include "core/simplify/fusion.h"

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
  Collapser(WorkingMesh& mesh, const ScoreScale& scale, const SizingField& field,
            const CollapseOptions& options)
      : mesh_(mesh), scale_(scale), field_(field), options_(options), versions_(mesh.points.size(), 0) {}

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
  void empty_heap() {
    while (mesh_.alive > options_.target && !heap_.empty()) {
      std::pop_heap(heap_.begin(), heap_.end());
      const Candidate c = heap_.back();
      heap_.pop_back();
      if (c.versions == versions_of(c.a, c.b) && !try_collapse(c.a, c.b)) parked_.push_back(c);
    }
  }

  std::uint32_t versions_of(Index a, Index b) const { return versions_[a] + versions_[b]; }

  double key_of(Index a, Index b) const {
    const Vec3 edge = mesh_.points[b] - mesh_.points[a];
    if (field_.is_empty()) return length_sq(edge);
    const double size = field_.relative_size(0.5 * (mesh_.points[a] + mesh_.points[b]));
    return length_sq(edge) / (size * size);
  }

  void enter_all() {
    for (Index a = 0; a < mesh_.points.size(); ++a) {
      collect_neighbours(a);
      for (const Index b : neighbours_) {
        if (a < b && (mesh_.is_free(a) || mesh_.is_free(b))) heap_.push_back({key_of(a, b), a, b, 0});
      }
    }
    std::make_heap(heap_.begin(), heap_.end());
  }

  void collect_neighbours(Index v) {
    marks_.clear(mesh_.points.size());
    marks_.set(v, 1);
    neighbours_.clear();
    for (const Index t : mesh_.star(v)) {
      for (const Index w : mesh_.tets[t]) {
        if (marks_.of(w) == 0) {
          marks_.set(w, 1);
          neighbours_.push_back(w);
        }
      }
    }
  }

  /// Fills the cone with the tets around `center` that lack `other`; returns the worst known score of all
  /// tets around it.
  void add_cone(Index center, Index other) {
    for (const Index t : mesh_.star(center)) {
      const Tet& tet = mesh_.tets[t];
      if (corners_that_are(tet, other) != 0U) continue;
      const auto corner = static_cast<std::size_t>(std::countr_zero(corners_that_are(tet, center)));
      const auto& face = kTetFaces[corner];
      cone_.add(mesh_.points[tet[static_cast<std::size_t>(face[0])]],
                mesh_.points[tet[static_cast<std::size_t>(face[1])]],
                mesh_.points[tet[static_cast<std::size_t>(face[2])]]);
      link_sum_ = link_sum_ + mesh_.points[tet[static_cast<std::size_t>(face[0])]] +
                  mesh_.points[tet[static_cast<std::size_t>(face[1])]] +
                  mesh_.points[tet[static_cast<std::size_t>(face[2])]];
    }
  }

  bool try_collapse(Index a, Index b) {
    Index gone = a;
    Index kept = b;
    if (!mesh_.is_free(gone)) std::swap(gone, kept);
    const bool kept_moves = mesh_.is_free(kept);
    cone_.clear();
    link_sum_ = {};
    add_cone(gone, kept);
    if (kept_moves) add_cone(kept, gone);
    if (cone_.size() == 0) return false;
    std::array<Vec3, 4> places{mesh_.points[kept]};
    std::size_t count = 1;
    if (kept_moves) {
      places[0] = 0.5 * (mesh_.points[a] + mesh_.points[b]);
      if (options_.placement == CollapsePlacement::kBest) {
        places[1] = (1.0 / (3.0 * static_cast<double>(cone_.size()))) * link_sum_;
        places[2] = mesh_.points[kept];
        places[3] = mesh_.points[gone];
        count = 4;
      }
    }
    double best = options_.least_score;
    const Vec3* place = nullptr;
    for (std::size_t i = 0; i < count; ++i) {
      const double worst = cone_.evaluate(scale_, places[i], best).worst;
      if (worst > best) {
        best = worst;
        place = &places[i];
      }
    }
    if (place == nullptr || (best < kSafeScore && !cone_.is_positive_exactly(*place))) {
      ++report_.rejected_shape;
      return false;
    }
    if (!meets_link_condition(mesh_, gone, kept, marks_)) {
      ++report_.rejected_link;
      return false;
    }
    apply_collapse(mesh_, gone, kept, *place);
    ++report_.collapses;
    collect_neighbours(kept);
    ++versions_[kept];
    ++versions_[gone];
    for (const Index w : neighbours_) reenter(kept, w);
    return true;
  }

  void reenter(Index a, Index b) {
    if (!mesh_.is_free(a) && !mesh_.is_free(b)) return;
    heap_.push_back({key_of(a, b), a, b, versions_of(a, b)});
    std::push_heap(heap_.begin(), heap_.end());
  }

  WorkingMesh& mesh_;
  const ScoreScale& scale_;
  const SizingField& field_;
  const CollapseOptions& options_;
  CollapseReport report_;
  std::vector<std::uint32_t> versions_;
  std::vector<Candidate> heap_;
  std::vector<Candidate> parked_;
  std::vector<Index> neighbours_;
  VertexMarks marks_;
  Cone cone_;
  Vec3 link_sum_;
};

}  // namespace

CollapseReport collapse_edges(WorkingMesh& mesh, const ScoreScale& scale, const SizingField& field,
                              const CollapseOptions& options) {
  return Collapser(mesh, scale, field, options).run();
}

}  // namespace palpate::simplify

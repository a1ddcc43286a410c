#include "core/simplify/tet_operations/edge_collapse.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "core/mesh/geometry.h"
#include "core/simplify/tet_operations/shortest_edges.h"
#include "core/simplify/tet_operations/star_quality.h"

namespace palpate::simplify {
namespace {

/// So many edges are held at first: a collapse takes five or six tets away, and some are refused.
std::size_t edges_for(const WorkingMesh& mesh, const CollapseOptions& options) {
  constexpr std::uint64_t kTetsPerEdge = 3;
  constexpr std::size_t kAlways = 1024;
  const std::uint64_t more = mesh.alive > options.target ? mesh.alive - options.target : 0;
  return kAlways + static_cast<std::size_t>(more / kTetsPerEdge);
}

class Collapser {
 public:
  Collapser(WorkingMesh& mesh, const ScoreRule& rule, const CollapseOptions& options)
      : mesh_(mesh),
        rule_(rule),
        options_(options),
        edges_(mesh, rule.field(), edges_for(mesh, options)),
        changes_(mesh.points.size()) {}

  CollapseReport run() {
    for (level_ = 0; level_ < options_.least_scores.size(); ++level_) {
      std::uint64_t before = 0;
      do {
        before = report_.collapses;
        empty_heap();
        edges_.start_over();  // what was refused is looked at again, as stars have changed
      } while (mesh_.alive > options_.target && report_.collapses > before);
      if (mesh_.alive <= options_.target) break;
    }
    return report_;
  }

 private:
  void empty_heap() {
    while (mesh_.alive > options_.target) {
      std::optional<WaitingEdge> edge = edges_.pop();
      if (!edge || edge->key > options_.longest * options_.longest) return;
      if (edge->level <= level_ || changes_.has_changed_since(*edge)) {
        if (try_collapse(edge->a, edge->b)) continue;
        edge->level = static_cast<std::uint32_t>(next_level_);
      }
      changes_.mark_refused(*edge);
      edges_.park(*edge);
    }
  }

  double least_score() const { return options_.least_scores[level_]; }

  /// Mean of the star's base vertices, counted as often as they occur.
  Vec3 link_centroid(Index gone, Index survivor) {
    Vec3 sum{};
    std::size_t count = 0;
    for (const Index center : {gone, survivor}) {
      collect_neighbours(mesh_, center, marks_, neighbours_);
      for (const Index v : neighbours_) {
        if (v != gone && v != survivor) sum = sum + mesh_.points[v];
      }
      count += neighbours_.size() - 1;
    }
    return (1.0 / static_cast<double>(count)) * sum;
  }

  /// Whether there is a place where all tets are good enough; `place_` is set to it. If not, `next_level_` is
  /// set to the first level at which there may be one.
  bool find_place(Index gone, Index survivor) {
    most_ = -std::numeric_limits<double>::infinity();
    if (look_for_place(gone, survivor) > least_score()) return true;
    while (next_level_ < options_.least_scores.size() && !(most_ > options_.least_scores[next_level_]))
      ++next_level_;
    return false;
  }

  /// The worst score at `place_`, or no more than is permitted if there is no place.
  double look_for_place(Index gone, Index survivor) {
    const Vec3 at_gone = mesh_.points[gone];
    const Vec3 at_survivor = mesh_.points[survivor];
    if (!mesh_.is_free(survivor)) return try_place(at_survivor, least_score());
    double best = try_place(0.5 * (at_gone + at_survivor), least_score());
    if (options_.placement == CollapsePlacement::kMidpoint) return best;
    const auto is_enough = [&] {
      return options_.placement == CollapsePlacement::kFirst && best > least_score();
    };
    if (is_enough()) return best;
    for (const Vec3& place : {link_centroid(gone, survivor), at_survivor, at_gone}) {
      best = try_place(place, best);
      if (is_enough()) break;
    }
    return best;
  }

  /// The larger of `best` and the worst score with the apex at `place`, which is taken if that is larger.
  double try_place(const Vec3& place, double best) {
    const double worst = star_.evaluate(place, options_.least_scores.back()).worst;
    most_ = std::max(most_, worst);
    if (!(worst > best)) return best;
    place_ = place;
    return worst;
  }

  /// Whether all tets that are left around the edge are above the floor with its vertex at `place_`.
  bool holds_floor(Index gone, Index survivor) const {
    return options_.floor == nullptr || (options_.floor->admits_star(mesh_, gone, place_, {}, survivor) &&
                                         options_.floor->admits_star(mesh_, survivor, place_, {}, gone));
  }

  /// Whether a tet around `gone` would be inverted with `survivor`, where that is, in its place. What is told
  /// by rounded volumes alone is so flat that its score would be refused as well.
  bool turns_over(Index gone, Index survivor) const {
    const auto star = mesh_.star(gone);
    return std::any_of(star.begin(), star.end(), [&](Index t) {
      Tet tet = mesh_.tets[t];
      if (std::find(tet.begin(), tet.end(), survivor) != tet.end()) return false;  // it dies
      std::replace(tet.begin(), tet.end(), gone, survivor);
      const auto& p = mesh_.points;
      return signed_volume(p[tet[0]], p[tet[1]], p[tet[2]], p[tet[3]]) < 0.0;
    });
  }

  bool try_collapse(Index a, Index b) {
    next_level_ = level_ + 1;
    Index gone = a;
    Index survivor = b;
    if (!mesh_.is_free(gone)) std::swap(gone, survivor);
    // Most edges that cannot go are those to a vertex that stays where it is: no star is laid out for them.
    if (!mesh_.is_free(survivor) && turns_over(gone, survivor)) {
      next_level_ = options_.least_scores.size();
      ++report_.rejected_shape;
      return false;
    }
    star_.start(rule_.of_collapse(mesh_, gone, survivor, mesh_.points[survivor]), mesh_.points[survivor]);
    add_star(mesh_, gone, survivor, star_);
    if (mesh_.is_free(survivor)) add_star(mesh_, survivor, gone, star_);
    if (star_.size() == 0) return false;
    star_.close();
    if (!find_place(gone, survivor) || !star_.is_positive(place_) || !holds_floor(gone, survivor)) {
      ++report_.rejected_shape;
      return false;
    }
    if (!meets_link_condition(mesh_, gone, survivor, marks_)) {
      next_level_ = options_.least_scores.size();
      ++report_.rejected_link;
      return false;
    }
    apply_collapse(mesh_, gone, survivor, place_);
    ++report_.collapses;
    edges_.renew(gone, survivor);
    changes_.note(mesh_, survivor);
    return true;
  }

  WorkingMesh& mesh_;
  const ScoreRule& rule_;
  const CollapseOptions& options_;
  CollapseReport report_;
  ShortestEdges edges_;
  StarChanges changes_;
  std::size_t level_ = 0;       ///< place in options_.least_scores
  std::size_t next_level_ = 0;  ///< the first that may permit what this one has refused
  double most_ = 0.0;           ///< what the worst tet would score at most, in the best of the places tried
  std::vector<Index> neighbours_;
  VertexMarks marks_;
  StarQuality star_;
  Vec3 place_;
};

}  // namespace

CollapseReport collapse_edges(WorkingMesh& mesh, const ScoreRule& rule, const CollapseOptions& options) {
  return Collapser(mesh, rule, options).run();
}

}  // namespace palpate::simplify

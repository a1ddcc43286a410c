#include "core/simplify/surface/surface_collapse.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "core/simplify/fusion/fusion.h"
#include "core/simplify/tet_operations/edge_heap.h"

namespace palpate::simplify {
namespace {

/// Sum of squared distances from planes, weighted by the squares of twice the faces' areas, about an origin
/// near them:  E(p) = p.A p - 2 b.p + c.  And the volume below the faces, linear in p:  g.p = h keeps it.
struct PlaneSum {
  std::array<double, 6> a{};  ///< xx xy xz yy yz zz
  Vec3 b;
  double c = 0.0;
  Vec3 g;
  double h = 0.0;

  void add(const Vec3& p, const Vec3& q, const Vec3& r) {
    const Vec3 n = cross(q - p, r - p);
    const double d = dot(n, p);
    a[0] += n.x * n.x;
    a[1] += n.x * n.y;
    a[2] += n.x * n.z;
    a[3] += n.y * n.y;
    a[4] += n.y * n.z;
    a[5] += n.z * n.z;
    b = b + d * n;
    c += d * d;
    g = g + n;
    h += d;
  }

  double cost(const Vec3& p) const {
    const Vec3 ap{a[0] * p.x + a[1] * p.y + a[2] * p.z, a[1] * p.x + a[3] * p.y + a[4] * p.z,
                  a[2] * p.x + a[4] * p.y + a[5] * p.z};
    return dot(p, ap) - 2.0 * dot(b, p) + c;
  }

  /// Solves (A + weight I) x = r.
  Vec3 solve(const Vec3& r, double weight) const {
    const Vec3 u{a[0] + weight, a[1], a[2]};
    const Vec3 v{a[1], a[3] + weight, a[4]};
    const Vec3 w{a[2], a[4], a[5] + weight};
    const double determinant = dot(u, cross(v, w));
    return {dot(r, cross(v, w)) / determinant, dot(u, cross(r, w)) / determinant,
            dot(u, cross(v, r)) / determinant};
  }

  /// Where E is least under g.p = h, drawn a little towards the origin so that flat and straight skins have
  /// an answer too.
  Vec3 best_place() const {
    const double weight = 1e-3 * (a[0] + a[3] + a[5]);
    if (!(weight > 0.0)) return {};
    const Vec3 free = solve(b, weight);
    const Vec3 along = solve(g, weight);
    const double rate = dot(g, along);
    return rate > 0.0 ? free + ((h - dot(g, free)) / rate) * along : free;
  }
};

class BoundaryCollapser {
 public:
  BoundaryCollapser(WorkingMesh& mesh, GuardedBoundary& boundary, const ScoreRule& scores,
                    const SurfaceCollapseOptions& options, SurfaceReport& report)
      : mesh_(mesh),
        boundary_(boundary),
        scores_(scores),
        options_(options),
        report_(report),
        edges_(mesh, scores.field()),
        changes_(mesh.points.size()) {}

  void run() {
    boundary_.for_each_edge([this](Index a, Index b) {
      if (may_collapse(a, b)) edges_.append(a, b);
    });
    edges_.heapify();
    std::uint64_t before = 0;
    do {
      before = report_.collapses;
      empty_heap();
      edges_.start_over();  // what was refused is looked at again, as stars have changed
    } while (!is_done() && report_.collapses > before);
  }

 private:
  void empty_heap() {
    while (!is_done()) {
      std::optional<WaitingEdge> edge = edges_.pop();
      if (!edge || edge->key > options_.longest * options_.longest) return;
      if (changes_.has_changed_since(*edge) && try_collapse(edge->a, edge->b)) continue;
      changes_.mark_refused(*edge);
      edges_.park(*edge);
    }
  }

  bool is_done() const {
    return boundary_.size() <= options_.face_target || mesh_.alive <= options_.tet_target;
  }

  FeatureRank hold(Index v) const { return hold_on(mesh_, boundary_, v); }

  /// The end that is held less goes; from a line along it only.
  bool may_collapse(Index a, Index b) const {
    const FeatureRank least = std::min(hold(a), hold(b));
    return least == FeatureRank::kNone || (least == FeatureRank::kOnLine && boundary_.lines().is_line(a, b));
  }

  /// The link condition of the boundary: the ends' common neighbours on it are the two apexes of the edge's
  /// faces, and not both ends have a face with these apexes: that would be the skin of a single tet.
  bool boundary_stays_manifold(Index gone, Index survivor) {
    constexpr std::uint32_t kAtSurvivor = 1;
    constexpr std::uint32_t kApex = 2;
    marks_.clear(mesh_.points.size());
    for (const Index f : boundary_.faces_of(survivor)) {
      for (const Index v : boundary_.face(f)) marks_.set(v, kAtSurvivor);
    }
    std::size_t at_edge = 0;
    for (const Index f : boundary_.faces_of(gone)) {
      if (!has_corner(boundary_.face(f), survivor)) continue;
      ++at_edge;
      for (const Index v : boundary_.face(f)) {
        if (v != gone && v != survivor) marks_.set(v, kApex);
      }
    }
    if (at_edge != 2) return false;
    const auto joins_apexes = [&](Index f) {
      const Triangle& t = boundary_.face(f);
      return std::count_if(t.begin(), t.end(), [&](Index v) { return marks_.of(v) == kApex; }) == 2;
    };
    bool gone_joins = false;
    for (const Index f : boundary_.faces_of(gone)) {
      for (const Index v : boundary_.face(f)) {
        if (v != gone && v != survivor && marks_.of(v) == kAtSurvivor) return false;
      }
      gone_joins = gone_joins || joins_apexes(f);
    }
    const auto at_survivor = boundary_.faces_of(survivor);
    return !gone_joins || std::none_of(at_survivor.begin(), at_survivor.end(), joins_apexes);
  }

  void plan(Index gone, Index survivor, bool survivor_moves) {
    change_.removed.clear();
    change_.fresh.clear();
    change_.moved = survivor;
    planes_ = {};
    const Vec3 origin = 0.5 * (mesh_.points[gone] + mesh_.points[survivor]);
    const auto take = [&](Index f, bool is_fresh) {
      Triangle t = boundary_.face(f);
      planes_.add(mesh_.points[t[0]] - origin, mesh_.points[t[1]] - origin, mesh_.points[t[2]] - origin);
      change_.removed.push_back(f);
      if (!is_fresh) return;
      std::replace(t.begin(), t.end(), gone, survivor);
      change_.fresh.push_back(t);
    };
    for (const Index f : boundary_.faces_of(gone)) take(f, !has_corner(boundary_.face(f), survivor));
    if (!survivor_moves) return;
    for (const Index f : boundary_.faces_of(survivor)) {
      if (!has_corner(boundary_.face(f), gone)) take(f, true);
    }
  }

  /// Places for the new vertex, the most promising first. Returns how many.
  std::size_t list_places(Index gone, Index survivor, bool survivor_moves,
                          std::array<Vec3, 3>& places) const {
    places[0] = mesh_.points[survivor];
    if (!survivor_moves) return 1;
    const Vec3 origin = 0.5 * (mesh_.points[gone] + mesh_.points[survivor]);
    const Vec3 best = planes_.best_place();
    places = {origin + best, mesh_.points[survivor], mesh_.points[gone]};
    if (planes_.cost(places[2] - origin) < planes_.cost(places[1] - origin)) std::swap(places[1], places[2]);
    // A straight edge is kept to the bit by its ends, and by nothing else.
    const bool is_on_line = hold(gone) == FeatureRank::kOnLine;
    if (!is_on_line || !boundary_.lines().is_straight_at(mesh_, gone, survivor)) return 3;
    std::rotate(places.begin(), places.begin() + 1, places.end());
    return 2;
  }

  /// What the tets are worth that a collapse changes or takes away.
  double worth_around(Index gone, Index survivor, bool survivor_moves) const {
    const auto worth = [&](const Tet& v) {
      const std::vector<Vec3>& p = mesh_.points;
      return worth_of_tet(star_.scale(),
                          double{score_tet(star_.scale(), p[v[0]], p[v[1]], p[v[2]], p[v[3]])});
    };
    double sum = 0.0;
    for (const Index t : mesh_.star(gone)) sum += worth(mesh_.tets[t]);
    if (!survivor_moves) return sum;
    for (const Index t : mesh_.star(survivor)) {
      const Tet& tet = mesh_.tets[t];
      if (std::find(tet.begin(), tet.end(), gone) == tet.end()) sum += worth(tet);
    }
    return sum;
  }

  bool is_well_shaped(const Vec3& place, double worth_before) {
    const double least = options_.is_cure ? 0.0 : options_.least_score;
    const StarFigures figures = star_.evaluate(place, least);
    if (!(figures.worst > least)) return false;
    if (options_.is_cure && figures.worst <= options_.least_score) {
      const double usual = gain_of_score(star_.scale(), star_.scale().usual_score);  // as worth_of_tet has it
      if (figures.sum - usual * static_cast<double>(star_.size()) <= worth_before) return false;
    }
    return star_.is_positive(place);
  }

  bool try_collapse(Index a, Index b) {
    Index gone = a;
    Index survivor = b;
    if (hold(gone) > hold(survivor)) std::swap(gone, survivor);
    const bool survivor_moves = hold(gone) == hold(survivor);
    if (!boundary_stays_manifold(gone, survivor) || !meets_link_condition(mesh_, gone, survivor, marks_)) {
      ++report_.rejected_link;
      return false;
    }
    star_.start(scores_.of_collapse(mesh_, gone, survivor, mesh_.points[survivor]), mesh_.points[survivor]);
    add_star(mesh_, gone, survivor, star_);
    if (survivor_moves) add_star(mesh_, survivor, gone, star_);
    if (star_.size() == 0) return false;
    star_.close();
    const double worth_before = options_.is_cure ? worth_around(gone, survivor, survivor_moves) : 0.0;
    plan(gone, survivor, survivor_moves);
    std::array<Vec3, 3> places;
    const std::size_t count = list_places(gone, survivor, survivor_moves, places);
    BoundaryVerdict verdict = BoundaryVerdict::kAllowed;
    bool any_shape = false;
    bool any_line = hold(gone) == FeatureRank::kNone;
    for (std::size_t i = 0; i < count; ++i) {
      if (!is_well_shaped(places[i], worth_before)) continue;
      any_shape = true;
      change_.to = places[i];
      if (!line_permits(gone, survivor)) continue;
      any_line = true;
      verdict = boundary_.check(mesh_, change_);
      if (verdict != BoundaryVerdict::kAllowed) continue;
      collapse(gone, survivor);
      return true;
    }
    ++(!any_shape                             ? report_.rejected_shape
       : !any_line                            ? report_.rejected_feature
       : verdict == BoundaryVerdict::kContact ? report_.rejected_contact
                                              : report_.rejected_distance);
    return false;
  }

  bool line_permits(Index gone, Index survivor) {
    return hold(gone) == FeatureRank::kNone ||
           boundary_.lines().permits_collapse(mesh_, gone, survivor, change_.to);
  }

  void collapse(Index gone, Index survivor) {
    boundary_.apply(change_);
    if (hold(gone) == FeatureRank::kOnLine) boundary_.lines().collapse(gone, survivor);
    apply_collapse(mesh_, gone, survivor, change_.to);
    ++report_.collapses;
    changes_.note(mesh_, survivor);
    edges_.renew(gone);
    edges_.renew(survivor);
    for (const Index f : boundary_.faces_of(survivor)) {
      const Triangle& t = boundary_.face(f);
      const auto at = static_cast<std::size_t>(std::find(t.begin(), t.end(), survivor) - t.begin());
      const Index next = t[(at + 1) % 3];  // each neighbour follows on the survivor in one face
      if (may_collapse(survivor, next)) edges_.push(std::min(survivor, next), std::max(survivor, next));
    }
  }

  WorkingMesh& mesh_;
  GuardedBoundary& boundary_;
  const ScoreRule& scores_;
  const SurfaceCollapseOptions& options_;
  SurfaceReport& report_;
  EdgeHeap edges_;
  StarChanges changes_;
  VertexMarks marks_;
  StarQuality star_;
  PlaneSum planes_;
  BoundaryChange change_;
};

}  // namespace

void collapse_boundary_edges(WorkingMesh& mesh, GuardedBoundary& boundary, const ScoreRule& scores,
                             const SurfaceCollapseOptions& options, SurfaceReport& report) {
  BoundaryCollapser(mesh, boundary, scores, options, report).run();
}

}  // namespace palpate::simplify

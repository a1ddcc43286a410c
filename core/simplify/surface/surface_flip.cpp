#include "core/simplify/surface/surface_flip.h"

#include <algorithm>

#include "core/mesh/orientation.h"
#include "core/simplify/tet_operations/smoothing.h"

namespace palpate::simplify {
namespace {

/// A flip must better the worst score by this factor, or the sum of gains by so much, so that flips end.
constexpr double kGrowth = 1.02;
constexpr double kLeastGrowth = 1e-3;

Index third(const Triangle& t, Index a, Index b) {
  for (const Index v : t) {
    if (v != a && v != b) return v;
  }
  return kNoIndex;
}

double score_of(const WorkingMesh& mesh, const ScoreScale& scale, const Tet& t) {
  return score_tet(scale, mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]], mesh.points[t[3]]);
}

}  // namespace

bool BoundaryFlipper::find_fan(Index a, Index b, EdgeFan& fan) const {
  fan.a = a;
  fan.b = b;
  fan.size = 0;
  std::size_t at_edge = 0;
  for (const Index f : boundary_.faces_of(a)) {
    const Triangle& t = boundary_.face(f);
    if (!has_corner(t, b)) continue;
    if (++at_edge > 2) return false;
    const auto at = static_cast<std::size_t>(std::find(t.begin(), t.end(), a) - t.begin());
    const bool is_first = t[(at + 2) % 3] == b;  // (a, fan[0], b)
    fan.faces[is_first ? 0 : 1] = f;
  }
  if (at_edge != 2) return false;
  const Index last = third(boundary_.face(fan.faces[1]), a, b);
  fan.fan[0] = third(boundary_.face(fan.faces[0]), a, b);
  Index tet = kNoIndex;
  while (fan.fan[fan.size] != last) {
    if (fan.size == EdgeFan::kMostTets) return false;
    tet = neighbour_across(mesh_, tet, a, b, fan.fan[fan.size]);
    if (tet == kNoIndex || mesh_.is_kept(tet)) return false;
    Index next = kNoIndex;
    for (const Index v : mesh_.tets[tet]) {
      if (v != a && v != b && v != fan.fan[fan.size]) next = v;
    }
    fan.tets[fan.size++] = tet;
    fan.fan[fan.size] = next;
  }
  return fan.size > 0;
}

double BoundaryFlipper::worst_score(const EdgeFan& fan) {
  double worst = 1e300;
  for (std::size_t i = 0; i < fan.size; ++i) {
    float& score = mesh_.score[fan.tets[i]];
    if (score == WorkingMesh::kNoScore)
      score = static_cast<float>(score_of(mesh_, scale_, mesh_.tets[fan.tets[i]]));
    worst = std::min(worst, double{score});
  }
  return worst;
}

/// The two tets over triangle (i, j, k) of the fan.
std::array<Tet, 2> BoundaryFlipper::pair_over(const EdgeFan& fan, std::size_t i, std::size_t j,
                                              std::size_t k) const {
  return {Tet{fan.fan[i], fan.fan[j], fan.fan[k], fan.b}, Tet{fan.a, fan.fan[i], fan.fan[j], fan.fan[k]}};
}

/// Takes the triangles over the polygon fan[0 .. size] with the greatest worst score, by Klincsek's dynamic
/// programming, if it is above the worst of now.
bool BoundaryFlipper::raises_worst(const EdgeFan& fan, double worst) {
  constexpr std::size_t kMost = EdgeFan::kMostTets + 1;
  std::array<std::array<double, kMost>, kMost> best{};
  for (std::size_t i = 0; i < fan.size; ++i) best[i][i + 1] = 1e300;
  for (std::size_t span = 2; span <= fan.size; ++span) {
    for (std::size_t i = 0; i + span <= fan.size; ++i) {
      const std::size_t k = i + span;
      best[i][k] = -1e300;
      for (std::size_t j = i + 1; j < k; ++j) {
        const auto [over_b, over_a] = pair_over(fan, i, j, k);
        const double here = std::min(
            {best[i][j], best[j][k], score_of(mesh_, scale_, over_b), score_of(mesh_, scale_, over_a)});
        if (here <= best[i][k]) continue;
        best[i][k] = here;
        apex_[i][k] = j;
      }
    }
  }
  const double reached = best[0][fan.size];
  if (fan.size > 1 && !(reached > 0.0 && reached > kGrowth * worst)) return false;
  triangles_.clear();
  list_triangles(0, fan.size);
  return true;
}

void BoundaryFlipper::list_triangles(std::size_t i, std::size_t k) {
  if (k < i + 2) return;
  const std::size_t j = apex_[i][k];
  triangles_.push_back({i, j, k});
  list_triangles(i, j);
  list_triangles(j, k);
}

/// Takes the triangles with the greatest sum of gains, if it is above that of now.
bool BoundaryFlipper::raises_sum(const EdgeFan& fan, double worst) {
  double before = 0.0;
  for (std::size_t i = 0; i < fan.size; ++i) before += worth_of_tet(scale_, double{mesh_.score[fan.tets[i]]});
  triangles_.clear();
  if (fan.size == 1) return kLeastGrowth < -before;  // nothing is left of it
  const double least = kLeastOfWorst * worst;
  const auto is_enough = [&](double score) { return score > 0.0 && score >= least; };
  const std::size_t corners = fan.size + 1;
  for (std::size_t i = 0; i + 2 < corners; ++i) {
    for (std::size_t j = i + 1; j + 1 < corners; ++j) {
      for (std::size_t k = j + 1; k < corners; ++k) {
        const auto [over_b, over_a] = pair_over(fan, i, j, k);
        const double at_b = score_of(mesh_, scale_, over_b);
        const double at_a = is_enough(at_b) ? score_of(mesh_, scale_, over_a) : 0.0;
        value_[i][j][k] =
            is_enough(at_a) ? worth_of_tet(scale_, at_b) + worth_of_tet(scale_, at_a) : kForbidden;
      }
    }
  }
  const double after = best_ring_filling(value_, corners, triangles_);
  return after != kForbidden && after > before + kLeastGrowth;
}

/// Whether one of the edges of the two new faces would be sharp that is on no line and was not: sharper than
/// a right angle, where none may be folded, or sharp enough for a line.
bool BoundaryFlipper::makes_edge_sharp(const EdgeFan& fan) const {
  const FeatureLines& lines = boundary_.lines();
  if (may_fold_ && lines.is_empty()) return false;
  const auto is_sharp = [&](const Vec3& normal, const Vec3& other) {
    return (!may_fold_ && dot(normal, other) < 0.0) || (!lines.is_empty() && lines.is_sharp(normal, other));
  };
  const auto normal_of = [&](const Triangle& t) {
    const Vec3& p = mesh_.points[t[0]];
    return cross(mesh_.points[t[1]] - p, mesh_.points[t[2]] - p);
  };
  const std::array<Vec3, 2> before{normal_of(boundary_.face(fan.faces[0])),
                                   normal_of(boundary_.face(fan.faces[1]))};
  const std::array<Vec3, 2> after{normal_of(change_.fresh[0]), normal_of(change_.fresh[1])};  // at a and at b
  if (is_sharp(after[0], after[1]) && !is_sharp(before[0], before[1])) return true;
  const std::array<Index, 2> ends{fan.a, fan.b};
  const std::array<Index, 2> outer{fan.fan[0], fan.fan[fan.size]};
  for (std::size_t i = 0; i < 2; ++i) {
    for (std::size_t k = 0; k < 2; ++k) {
      if (lines.is_line(ends[i], outer[k])) continue;
      for (const Index f : boundary_.faces_of(ends[i])) {
        if (f == fan.faces[0] || f == fan.faces[1] || !has_corner(boundary_.face(f), outer[k])) continue;
        const Vec3 beyond = normal_of(boundary_.face(f));
        if (is_sharp(after[i], beyond) && !is_sharp(before[k], beyond)) return true;
      }
    }
  }
  return false;
}

/// The new edge must be new on the boundary, and inside too unless a tet is peeled off it.
bool BoundaryFlipper::is_permitted(const EdgeFan& fan) {
  const Index first = fan.fan[0];
  const Index last = fan.fan[fan.size];
  for (const Index f : boundary_.faces_of(first)) {
    if (has_corner(boundary_.face(f), last)) return false;
  }
  if (fan.size > 1) {
    collect_edge_star(mesh_, first, last, added_);
    if (!added_.empty()) return false;
  }
  change_.removed.assign(fan.faces.begin(), fan.faces.end());
  change_.fresh = {{fan.a, first, last}, {first, fan.b, last}};
  change_.moved = kNoIndex;
  return !makes_edge_sharp(fan) && boundary_.check(mesh_, change_) == BoundaryVerdict::kAllowed;
}

bool BoundaryFlipper::try_flip(Index a, Index b, double threshold) {
  if (boundary_.lines().is_line(a, b)) return false;
  EdgeFan fan;
  if (!find_fan(a, b, fan)) return false;
  scale_ = scores_.at(0.5 * (mesh_.points[a] + mesh_.points[b]));
  const double worst = worst_score(fan);
  if (worst >= threshold) return refuse(fan);
  if (fan.size == 1 && mesh_.alive <= fewest_tets_) return false;
  if (fan.size > 2 && mesh_.alive + fan.size - 2 > most_tets_) return false;
  if (!(aim_ == FlipAim::kSum ? raises_sum(fan, worst) : raises_worst(fan, worst))) return refuse(fan);
  fresh_.clear();
  for (const auto& [i, j, k] : triangles_) {
    const auto [at_b, at_a] = pair_over(fan, i, j, k);
    fresh_.push_back(at_b);
    fresh_.push_back(at_a);
  }
  const auto is_positive = [&](const Tet& t) {
    const std::vector<Vec3>& p = mesh_.points;
    return orientation(p[t[0]], p[t[1]], p[t[2]], p[t[3]]) > 0;
  };
  if (!std::all_of(fresh_.begin(), fresh_.end(), is_positive) || !is_permitted(fan)) return false;
  boundary_.apply(change_);
  apply_flip(mesh_, std::span<const Index>(fan.tets.data(), fan.size), fresh_, added_);
  note_flip(fan);
  return true;
}

/// The tets around the edge speak against a flip, whatever the rest of the mesh is like. Returns false.
bool BoundaryFlipper::refuse(const EdgeFan& fan) {
  for (const Index f : fan.faces) {
    if (refused_.size() <= f) refused_.resize(f + 1, {});
    const Triangle& t = boundary_.face(f);
    for (std::size_t side = 0; side < 3; ++side) {
      const Index opposite = t[(side + 2) % 3];
      if (opposite != fan.a && opposite != fan.b) refused_[f][side] = clock_;
    }
  }
  return false;
}

void BoundaryFlipper::note_flip(const EdgeFan& fan) {
  flipped_.resize(mesh_.points.size(), 0);
  flipped_[fan.a] = clock_;
  flipped_[fan.b] = clock_;
  for (std::size_t i = 0; i <= fan.size; ++i) flipped_[fan.fan[i]] = clock_;
  for (const Index f : fan.faces) {
    if (f < refused_.size()) refused_[f] = {};
  }
  ++clock_;
}

/// Whether no flip since has touched both ends of the edge at a side, so that the tets around it are the
/// same.
bool BoundaryFlipper::is_refused_still(Index f, std::size_t side) const {
  if (f >= refused_.size() || refused_[f][side] == 0) return false;
  const Triangle& t = boundary_.face(f);
  const auto is_touched = [&](Index v) { return v < flipped_.size() && flipped_[v] >= refused_[f][side]; };
  return !is_touched(t[side]) || !is_touched(t[(side + 1) % 3]);
}

std::uint64_t BoundaryFlipper::pass(double threshold) {
  std::uint64_t flips = 0;
  refused_.clear();  // of a pass before: vertices have moved since
  for (Index f = 0; f < boundary_.slots(); ++f) {
    for (std::size_t k = 0; k < 3 && boundary_.is_alive(f); ++k) {
      if (is_refused_still(f, k)) continue;
      const Triangle t = boundary_.face(f);
      const Index a = std::min(t[k], t[(k + 1) % 3]);
      const Index b = std::max(t[k], t[(k + 1) % 3]);
      if (try_flip(a, b, threshold)) ++flips;
    }
  }
  return flips;
}

}  // namespace palpate::simplify

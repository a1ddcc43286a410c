#include "core/simplify/skin_guard/feature_lines.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/base/error.h"

namespace palpate::simplify {
namespace {

/// Sine of the turn below which a line is straight.
constexpr double kStraight = 1e-9;

/// A side of a face: its ends, the lesser number first, and the face's normal (twice its area long).
struct FaceSide {
  std::array<Index, 2> ends{};
  Vec3 normal;
};

std::vector<FaceSide> sorted_sides(const WorkingMesh& mesh, std::span<const Triangle> faces) {
  std::vector<FaceSide> sides;
  sides.reserve(3 * faces.size());
  for (const Triangle& t : faces) {
    const Vec3& p = mesh.points[t[0]];
    const Vec3 normal = cross(mesh.points[t[1]] - p, mesh.points[t[2]] - p);
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax(t[k], t[(k + 1) % 3]);
      sides.push_back({{low, high}, normal});
    }
  }
  std::stable_sort(sides.begin(), sides.end(),
                   [](const FaceSide& a, const FaceSide& b) { return a.ends < b.ends; });
  return sides;
}

/// Whether the angle between two directions is greater than the one with this cosine; never with a zero one.
bool differ_by_more(const Vec3& a, const Vec3& b, double cosine) {
  const double size = std::sqrt(length_sq(a)) * std::sqrt(length_sq(b));
  return size > 0.0 && dot(a, b) < cosine * size;
}

void erase_number(std::vector<Index>& numbers, Index number) {
  const auto found = std::find(numbers.begin(), numbers.end(), number);
  require(found != numbers.end(), "feature lines: an edge is not where it should be");
  numbers.erase(found);
}

}  // namespace

FeatureLines::FeatureLines(const WorkingMesh& mesh, std::span<const Triangle> faces, double angle_deg,
                           double limit)
    : cosine_(std::cos(angle_deg * std::numbers::pi / 180.0)),
      of_vertex_(mesh.points.size()),
      rank_(mesh.points.size(), FeatureRank::kNone),
      cover_(limit) {
  find_edges(mesh, faces);
  alive_ = edges_.size();
  if (edges_.empty()) return;
  find_corners(mesh);
  std::vector<Triangle> as_triangles;
  for (Index e = 0; e < edges_.size(); ++e) {
    const auto& [a, b] = edges_[e];
    as_triangles.push_back({a, b, b});
    input_.push_back({mesh.points[a], mesh.points[b]});
    covering_.push_back({e});
    covered_by_.push_back({e});
  }
  tree_.emplace(mesh.points, as_triangles);
}

bool FeatureLines::is_sharp(const Vec3& normal, const Vec3& other) const {
  return differ_by_more(normal, other, cosine_);
}

void FeatureLines::find_edges(const WorkingMesh& mesh, std::span<const Triangle> faces) {
  const std::vector<FaceSide> sides = sorted_sides(mesh, faces);
  for (std::size_t i = 0; i < sides.size();) {
    std::size_t end = i + 1;
    while (end < sides.size() && sides[end].ends == sides[i].ends) ++end;
    if (end - i != 2 || differ_by_more(sides[i].normal, sides[i + 1].normal, cosine_)) {
      edges_.push_back(sides[i].ends);
      link(static_cast<Index>(edges_.size() - 1));
    }
    i = end;
  }
}

void FeatureLines::find_corners(const WorkingMesh& mesh) {
  for (Index v = 0; v < of_vertex_.size(); ++v) {
    const std::vector<Index>& at = of_vertex_[v];
    if (at.empty()) continue;
    const auto turns = [&] {
      const Vec3 in = mesh.points[v] - mesh.points[other_end(at[0], v)];
      return differ_by_more(in, mesh.points[other_end(at[1], v)] - mesh.points[v], cosine_);
    };
    rank_[v] = at.size() != 2 || turns() ? FeatureRank::kCorner : FeatureRank::kOnLine;
  }
}

std::size_t FeatureLines::corners() const {
  return static_cast<std::size_t>(std::count(rank_.begin(), rank_.end(), FeatureRank::kCorner));
}

bool FeatureLines::is_line(Index a, Index b) const {
  if (rank(a) == FeatureRank::kNone || rank(b) == FeatureRank::kNone) return false;
  return std::any_of(of_vertex_[a].begin(), of_vertex_[a].end(),
                     [&](Index e) { return other_end(e, a) == b; });
}

bool FeatureLines::is_straight_at(const WorkingMesh& mesh, Index a, Index b) const {
  const Vec3 edge = mesh.points[b] - mesh.points[a];
  for (const Index v : {a, b}) {
    if (rank_[v] != FeatureRank::kOnLine) continue;
    for (const Index e : of_vertex_[v]) {
      const Vec3 next = mesh.points[other_end(e, v)] - mesh.points[v];
      if (length_sq(cross(edge, next)) > kStraight * kStraight * length_sq(edge) * length_sq(next))
        return false;
    }
  }
  return true;
}

void FeatureLines::raise_limit(double limit) {
  const LineCover raised(limit);
  require(raised.limit_sq() >= cover_.limit_sq(), "feature lines: a limit may only grow");
  cover_ = raised;
}

void FeatureLines::renumber(const std::vector<Index>& new_number, std::size_t vertices) {
  if (is_empty()) return;
  std::vector<FeatureRank> rank(vertices, FeatureRank::kNone);
  for (Index v = 0; v < rank_.size(); ++v) {
    if (rank_[v] != FeatureRank::kNone) rank[new_number[v]] = rank_[v];
  }
  rank_ = std::move(rank);
  of_vertex_.assign(vertices, {});
  for (Index e = 0; e < edges_.size(); ++e) {
    if (edges_[e][0] == kNoIndex) continue;
    for (Index& v : edges_[e]) v = new_number[v];
    link(e);
  }
}

void FeatureLines::link(Index e) {
  for (const Index v : edges_[e]) of_vertex_[v].push_back(e);
}

void FeatureLines::unlink(Index e) {
  for (const Index v : edges_[e]) erase_number(of_vertex_[v], e);
}

/// Whether both ends have a line to one third vertex: the two edges would become one.
bool FeatureLines::would_fold(Index gone, Index survivor) const {
  return std::any_of(of_vertex_[gone].begin(), of_vertex_[gone].end(), [&](Index e) {
    const Index next = other_end(e, gone);
    return next != survivor && is_line(next, survivor);
  });
}

void FeatureLines::place_fresh(const WorkingMesh& mesh, Index gone, Index survivor, const Vec3& to) {
  removed_.clear();
  fresh_.clear();
  Index between = kNoIndex;
  for (const Index e : of_vertex_[gone]) {
    const Index next = other_end(e, gone);
    if (next == survivor) {
      between = e;
      continue;
    }
    removed_.push_back(e);
    fresh_.push_back({mesh.points[next], to});
  }
  if (to != mesh.points[survivor]) {
    for (const Index e : of_vertex_[survivor]) {
      if (e == between) continue;
      removed_.push_back(e);
      fresh_.push_back({mesh.points[other_end(e, survivor)], to});
    }
  }
  require(between != kNoIndex, "feature lines: the ends have no edge");
  removed_.push_back(between);
}

/// What may cover the input's edges afterwards: the fresh edges, then those that stay at their ends.
void FeatureLines::list_candidates(const WorkingMesh& mesh, Index gone, Index survivor) {
  candidates_ = fresh_;
  around_.clear();
  const auto take = [&](Index v) {
    for (const Index e : of_vertex_[v]) {
      if (std::find(removed_.begin(), removed_.end(), e) != removed_.end()) continue;
      if (std::find(around_.begin(), around_.end(), e) != around_.end()) continue;
      around_.push_back(e);
      candidates_.push_back({mesh.points[edges_[e][0]], mesh.points[edges_[e][1]]});
    }
  };
  for (const Index e : removed_) {
    for (const Index v : edges_[e]) {
      if (v != gone) take(v);
    }
  }
  take(survivor);
}

bool FeatureLines::input_stays_near() {
  proofs_.clear();
  std::vector<Index> concerned;
  for (const Index e : removed_) {
    for (const Index i : covered_by_[e]) {
      if (std::find(covering_[i].begin(), covering_[i].end(), e) != covering_[i].end())
        concerned.push_back(i);
    }
  }
  std::sort(concerned.begin(), concerned.end());
  concerned.erase(std::unique(concerned.begin(), concerned.end()), concerned.end());
  for (const Index i : concerned) {
    if (!cover_.is_covered(input_[i], candidates_, used_)) return false;
    Proof proof{i, {}};
    for (const Index u : used_) {
      proof.covering.push_back(u < fresh_.size() ? removed_[u] : around_[u - fresh_.size()]);
    }
    proofs_.push_back(std::move(proof));
  }
  return true;
}

bool FeatureLines::permits_collapse(const WorkingMesh& mesh, Index gone, Index survivor, const Vec3& to) {
  if (would_fold(gone, survivor)) return false;
  place_fresh(mesh, gone, survivor, to);
  list_candidates(mesh, gone, survivor);
  return std::all_of(fresh_.begin(), fresh_.end(),
                     [&](const SegmentEnds& edge) { return cover_.is_covered(edge, *tree_); }) &&
         input_stays_near();
}

void FeatureLines::collapse(Index gone, Index survivor) {
  for (const Index e : removed_) {
    unlink(e);
    covered_by_[e].clear();
  }
  for (const Index e : removed_) {
    if (e == removed_.back()) {
      edges_[e][0] = kNoIndex;
      continue;
    }
    std::replace(edges_[e].begin(), edges_[e].end(), gone, survivor);
    link(e);
  }
  rank_[gone] = FeatureRank::kNone;
  --alive_;
  for (Proof& proof : proofs_) {
    for (const Index e : proof.covering) {
      std::vector<Index>& covered = covered_by_[e];
      if (std::find(covered.begin(), covered.end(), proof.input) == covered.end())
        covered.push_back(proof.input);
    }
    covering_[proof.input] = std::move(proof.covering);
  }
}

}  // namespace palpate::simplify

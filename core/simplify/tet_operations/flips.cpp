#include "core/simplify/tet_operations/flips.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "core/base/error.h"
#include "core/mesh/orientation.h"
#include "core/simplify/fusion/fusion.h"

namespace palpate::simplify {
namespace {

Index corner_of(const Tet& tet, int local) {
  return tet[static_cast<std::size_t>(local)];
}

/// The two vertices of `tet` beside a and b, such that (a, b, first, second) is positive.
std::array<Index, 2> ring_pair(const Tet& tet, Index a, Index b) {
  const auto& face = kTetFaces[static_cast<std::size_t>(std::countr_zero(corners_that_are(tet, a)))];
  const std::array<Index, 3> opposite{corner_of(tet, face[0]), corner_of(tet, face[1]),
                                      corner_of(tet, face[2])};
  const std::size_t at_b = opposite[0] == b ? 0U : (opposite[1] == b ? 1U : 2U);
  return {opposite[(at_b + 1) % 3], opposite[(at_b + 2) % 3]};
}

/// The bit of the arc of a ring from i to j.
constexpr std::size_t arc_of(std::size_t i, std::size_t j) {
  return 8 * i + j;
}

/// The triangles of a ring, those with the shortest arc from first to last vertex first.
struct RingOrder {
  struct Triangle {
    std::size_t number = 0;   ///< in the order of ring_triangles()
    std::uint64_t sides = 0;  ///< the arcs from i to k and from k to j
    std::uint64_t arc = 0;    ///< the arc from i to j
  };
  std::array<Triangle, RingTriangles::kMostLanes> triangles{};
  std::size_t size = 0;
};

constexpr RingOrder build_ring_order(std::size_t count) {
  RingOrder order;
  for (std::size_t width = 2; width < count; ++width) {
    std::size_t number = 0;
    for (std::size_t i = 0; i + 2 < count; ++i) {
      for (std::size_t k = i + 1; k + 1 < count; ++k) {
        for (std::size_t j = k + 1; j < count; ++j, ++number) {
          if (j - i != width) continue;
          order.triangles[order.size++] = {
              number, std::uint64_t{1} << arc_of(i, k) | std::uint64_t{1} << arc_of(k, j),
              std::uint64_t{1} << arc_of(i, j)};
        }
      }
    }
  }
  return order;
}

}  // namespace

bool order_edge_ring(const WorkingMesh& mesh, Index a, Index b, const Index* tets, std::size_t count,
                     EdgeRing& ring) {
  if (count < 3) return false;
  std::array<std::array<Index, 2>, kLargestRing> pairs;
  for (std::size_t i = 0; i < count; ++i) {
    pairs[i] = ring_pair(mesh.tets[tets[i]], a, b);
    ring.tets[i] = tets[i];
  }
  for (std::size_t i = 0; i + 1 < count; ++i) {  // bring the successor of pair i behind it
    std::size_t j = i + 1;
    while (j < count && pairs[j][0] != pairs[i][1]) ++j;
    if (j == count) return false;
    std::swap(pairs[i + 1], pairs[j]);
    std::swap(ring.tets[i + 1], ring.tets[j]);
  }
  if (pairs[count - 1][1] != pairs[0][0]) return false;
  ring.a = a;
  ring.b = b;
  ring.size = count;
  for (std::size_t i = 0; i < count; ++i) ring.ring[i] = pairs[i][0];
  return true;
}

bool find_edge_ring(const WorkingMesh& mesh, Index a, Index b, EdgeRing& ring) {
  std::array<Index, kLargestRing> tets{};
  std::size_t count = 0;
  const Index around = mesh.star_size[b] < mesh.star_size[a] ? b : a;
  const Index other = around == a ? b : a;
  for (const Index t : mesh.star(around)) {
    if (corners_that_are(mesh.tets[t], other) == 0U) continue;
    if (count == kLargestRing || mesh.is_kept(t)) return false;
    tets[count++] = t;
  }
  return order_edge_ring(mesh, a, b, tets.data(), count, ring);
}

double best_ring_filling(const RingValues& value, std::size_t size, std::vector<RingTriangle>& triangles) {
  std::array<std::array<double, kLargestRing>, kLargestRing> best{};
  std::array<std::array<std::size_t, kLargestRing>, kLargestRing> apex{};
  for (std::size_t width = 2; width < size; ++width) {
    for (std::size_t i = 0; i + width < size; ++i) {
      const std::size_t j = i + width;
      best[i][j] = kForbidden;
      for (std::size_t k = i + 1; k < j; ++k) {
        if (value[i][k][j] == kForbidden || best[i][k] == kForbidden || best[k][j] == kForbidden) continue;
        const double sum = best[i][k] + best[k][j] + value[i][k][j];
        if (sum > best[i][j]) {
          best[i][j] = sum;
          apex[i][j] = k;
        }
      }
    }
  }
  triangles.clear();
  if (best[0][size - 1] == kForbidden) return kForbidden;
  std::array<std::array<std::size_t, 2>, kLargestRing> arcs{};
  std::size_t waiting = 0;
  arcs[waiting++] = {0, size - 1};
  while (waiting > 0) {
    const auto [i, j] = arcs[--waiting];
    if (j < i + 2) continue;
    const std::size_t k = apex[i][j];
    triangles.push_back({i, k, j});
    arcs[waiting++] = {i, k};
    arcs[waiting++] = {k, j};
  }
  return best[0][size - 1];
}

bool can_fill_ring(std::uint64_t allowed, std::size_t size) {
  static constexpr std::array<RingOrder, kLargestRing - 2> kOrders = [] {
    std::array<RingOrder, kLargestRing - 2> all{};
    for (std::size_t n = 3; n <= kLargestRing; ++n) all[n - 3] = build_ring_order(n);
    return all;
  }();
  if (size < 3) return false;  // no ring
  std::uint64_t filled = 0;    // of arcs; bit arc_of(i, j)
  for (std::size_t i = 0; i + 1 < size; ++i) filled |= std::uint64_t{1} << arc_of(i, i + 1);
  const RingOrder& order = kOrders.at(size - 3);
  for (std::size_t n = 0; n < order.size; ++n) {
    const RingOrder::Triangle& t = order.triangles[n];
    if ((allowed >> t.number & 1U) != 0U && (filled & t.sides) == t.sides) filled |= t.arc;
  }
  return (filled >> arc_of(0, size - 1) & 1U) != 0U;
}

double Flipper::known_score(Index t) {
  float& score = mesh_.score[t];
  if (score == WorkingMesh::kNoScore) {
    const Tet& tet = mesh_.tets[t];
    const Vec3& a = mesh_.points[tet[0]];
    score = std::max(
        0.0F, score_tet(scores_.at(a), a, mesh_.points[tet[1]], mesh_.points[tet[2]], mesh_.points[tet[3]]));
  }
  return double{score};
}

Flipper::Before Flipper::measure_before(const Index* tets, std::size_t count) {
  Before before{0.0, 1e300};
  for (std::size_t i = 0; i < count; ++i) {
    const double score = known_score(tets[i]);
    before.sum += worth_of_tet(scores_.far(), score);
    before.worst = std::min(before.worst, score);
  }
  return before;
}

bool Flipper::is_all_positive(const std::vector<Tet>& tets) const {
  return std::all_of(tets.begin(), tets.end(), [&](const Tet& t) {
    return orientation(mesh_.points[t[0]], mesh_.points[t[1]], mesh_.points[t[2]], mesh_.points[t[3]]) > 0;
  });
}

bool Flipper::flip(const Index* old, std::size_t count) {
  if (!is_all_positive(fresh_)) return false;
  if (floor_ != nullptr && !std::all_of(fresh_.begin(), fresh_.end(),
                                        [&](const Tet& tet) { return floor_->admits(mesh_, tet); })) {
    return false;
  }
  removed_.clear();
  for (std::size_t i = 0; i < count; ++i) removed_.push_back(mesh_.tets[old[i]]);
  apply_flip(mesh_, {old, count}, fresh_, added_);
  for (std::size_t i = 0; i < fresh_scores_.size(); ++i) mesh_.score[added_[i]] = fresh_scores_[i];
  split_vertex_ = kNoIndex;
  return true;
}

void Flipper::undo() {
  std::vector<Index> slots;
  apply_flip(mesh_, added_, removed_, slots);
  if (split_vertex_ != kNoIndex) remove_vertex(mesh_, split_vertex_);
}

bool Flipper::try_remove_edge(Index a, Index b) {
  EdgeRing ring;
  return find_edge_ring(mesh_, a, b, ring) && try_ring(ring);
}

bool Flipper::try_edges_of(Index tet) {
  const Tet corners = mesh_.tets[tet];
  const double score = known_score(tet);
  std::array<std::array<Index, kLargestRing>, 6> tets;
  std::array<std::size_t, 6> count{};
  unsigned open = 0x3f;  // bit e: edge e, in the order of kTetEdges, is still a candidate
  const auto meet = [&](std::size_t edge, Index t) {
    if ((open >> edge & 1U) == 0U) return;
    const double other = known_score(t);
    if (count[edge] == rule_.largest_ring || mesh_.is_kept(t) || other < score ||
        (other == score && t < tet)) {
      open &= ~(1U << edge);
    } else {
      tets[edge][count[edge]++] = t;
    }
  };
  constexpr std::array<std::size_t, 4> kFirstEdge{0, 3, 5, 6};  // of corner 0, 1, 2
  for (std::size_t i = 0; i < 3; ++i) {
    const unsigned edges_of_corner = ((1U << (3 - i)) - 1U) << kFirstEdge[i];
    for (const Index t : mesh_.star(corners[i])) {
      if ((open & edges_of_corner) == 0U) break;
      for (std::size_t e = kFirstEdge[i]; e < kFirstEdge[i + 1]; ++e) {
        if (corners_that_are(mesh_.tets[t], corners[i + 1 + e - kFirstEdge[i]]) != 0U) meet(e, t);
      }
    }
  }
  EdgeRing ring;
  for (std::size_t e = 0; e < 6; ++e) {
    if ((open >> e & 1U) == 0U) continue;
    const Index a = corner_of(corners, kTetEdges[e][0]);
    const Index b = corner_of(corners, kTetEdges[e][1]);
    if (order_edge_ring(mesh_, a, b, tets[e].data(), count[e], ring) && try_ring(ring)) return true;
  }
  return false;
}

void Flipper::take_ring(const EdgeRing& ring) {
  RingPoints points{};
  for (std::size_t i = 0; i < ring.size; ++i) points[i] = &mesh_.points[ring.ring[i]];
  star_.start(scores_.at(mesh_.points[ring.a]), mesh_.points[ring.a]);
  star_.take_ring(points, ring.size);
}

/// Whether the ring that was taken can be filled at all, as far as the signs of volumes tell.
bool Flipper::can_be_filled(const EdgeRing& ring) const {
  const std::uint64_t allowed = star_.find_positive(mesh_.points[ring.a], mesh_.points[ring.b]);
  return can_fill_ring(allowed, ring.size);
}

void Flipper::measure_ring(const EdgeRing& ring, double least_score, RingValues& value) {
  const std::size_t n = ring.size;
  const ScoreScale& scale = star_.scale();
  star_.score_both(mesh_.points[ring.a], mesh_.points[ring.b], scores_a_, scores_b_);
  std::size_t at = 0;
  for (std::size_t i = 0; i + 2 < n; ++i) {
    for (std::size_t k = i + 1; k + 1 < n; ++k) {
      for (std::size_t j = k + 1; j < n; ++j, ++at) {
        const double worst = double{std::min(scores_a_[at], scores_b_[at])};
        value[i][k][j] = worst > 0.0 && worst >= least_score ? worth_of_tet(scale, double{scores_a_[at]}) +
                                                                   worth_of_tet(scale, double{scores_b_[at]})
                                                             : kForbidden;
      }
    }
  }
}

bool Flipper::try_ring(const EdgeRing& ring) {
  const std::size_t n = ring.size;
  if (n > rule_.largest_ring) return false;
  const std::size_t tets_after = mesh_.alive + n - 4;
  if (tets_after > rule_.most_tets || tets_after < rule_.fewest_tets) return false;
  const Before before = measure_before(ring.tets.data(), n);
  take_ring(ring);
  if (!can_be_filled(ring)) return false;
  measure_ring(ring, rule_.least_of_worst * before.worst, value_);
  const double sum = best_ring_filling(value_, n, triangles_);
  if (sum == kForbidden || !(sum > before.sum + rule_.least_growth)) return false;
  fresh_.clear();
  fresh_scores_.clear();
  for (const auto& [i, k, j] : triangles_) {
    // Position of (i, k, j) among all triangles: those with smaller i, then smaller k, then smaller j.
    std::size_t at = 0;
    for (std::size_t s = 0; s < i; ++s) at += (n - s - 1) * (n - s - 2) / 2;
    for (std::size_t s = i + 1; s < k; ++s) at += n - s - 1;
    at += j - k - 1;
    fresh_.push_back({ring.a, ring.ring[i], ring.ring[k], ring.ring[j]});
    fresh_.push_back({ring.b, ring.ring[i], ring.ring[j], ring.ring[k]});
    fresh_scores_.push_back(scores_a_[at]);
    fresh_scores_.push_back(scores_b_[at]);
  }
  growth_ = sum - before.sum;
  return flip(ring.tets.data(), n);
}

bool Flipper::try_remove_face(Index tet, std::size_t corner) {
  if (mesh_.alive + 1 > rule_.most_tets || mesh_.is_kept(tet)) return false;
  const Tet& t = mesh_.tets[tet];
  const Index p = t[corner];
  const auto [a, b, c] = face_opposite(t, corner);
  const Index other = neighbour_across(mesh_, tet, a, b, c);
  if (other == kNoIndex || mesh_.is_kept(other)) return false;
  Index q = kNoIndex;
  for (const Index v : mesh_.tets[other]) {
    if (v != a && v != b && v != c) q = v;
  }
  const std::array<Index, 2> old{tet, other};
  const Before before = measure_before(old.data(), old.size());
  fresh_.assign({Tet{p, a, b, q}, Tet{p, b, c, q}, Tet{p, c, a, q}});
  if (!is_all_positive(fresh_)) return false;
  const ScoreScale scale = scores_.at(mesh_.points[p]);
  star_.start(scale, mesh_.points[p]);
  for (const Tet& f : fresh_) star_.add(mesh_.points[f[1]], mesh_.points[f[2]], mesh_.points[f[3]]);
  star_.close();
  star_.scores(mesh_.points[p], fresh_scores_);
  double sum = 0.0;
  for (const float fresh : fresh_scores_) {
    const double score = double{fresh};
    if (score <= 0.0 || score < rule_.least_of_worst * before.worst) return false;
    sum += worth_of_tet(scale, score);
  }
  if (!(sum > before.sum + rule_.least_growth)) return false;
  growth_ = sum - before.sum;
  return flip(old.data(), old.size());
}

/// Puts `fresh_` in the place of `old`; `vertex` is new, and is given up again if that fails.
Index Flipper::flip_with_vertex(std::span<const Index> old, Index vertex) {
  fresh_scores_.clear();
  const Before before = measure_before(old.data(), old.size());
  if (!flip(old.data(), old.size())) {
    remove_vertex(mesh_, vertex);
    return kNoIndex;
  }
  split_vertex_ = vertex;
  growth_ = -before.sum;
  for (const Index t : added_) growth_ += worth_of_tet(scores_.far(), known_score(t));
  return vertex;
}

Index Flipper::split_edge(Index a, Index b) {
  EdgeRing ring;
  if (!find_edge_ring(mesh_, a, b, ring) || mesh_.alive + ring.size > rule_.most_tets) return kNoIndex;
  const Index middle = add_vertex(mesh_, 0.5 * (mesh_.points[a] + mesh_.points[b]));
  fresh_.clear();
  for (std::size_t i = 0; i < ring.size; ++i) {
    const Index r = ring.ring[i];
    const Index s = ring.ring[(i + 1) % ring.size];
    fresh_.push_back({a, middle, r, s});
    fresh_.push_back({middle, b, r, s});
  }
  return flip_with_vertex({ring.tets.data(), ring.size}, middle);
}

Index Flipper::insert_vertex(std::span<const Index> old, const Vec3& place, std::span<const Triangle> faces) {
  if (mesh_.alive - old.size() + faces.size() > rule_.most_tets) return kNoIndex;
  const Index middle = add_vertex(mesh_, place);
  fresh_.clear();
  for (const auto& [a, b, c] : faces) fresh_.push_back({middle, a, b, c});
  return flip_with_vertex(old, middle);
}

}  // namespace palpate::simplify

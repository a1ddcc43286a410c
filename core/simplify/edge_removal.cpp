#include "core/simplify/edge_removal.h"

#include <algorithm>
#include <bit>

#include "core/mesh/orientation.h"
#include "core/simplify/fusion.h"

namespace palpate::simplify {
namespace {

/// The two vertices of `tet` beside a and b, such that (a, b, first, second) is positive.
std::array<Index, 2> ring_pair(const Tet& tet, Index a, Index b) {
  const auto at_a = static_cast<std::size_t>(std::countr_zero(corners_that_are(tet, a)));
  const auto& face = kTetFaces[at_a];  // counter-clockwise from outside: (a, face) is positive
  const std::array<Index, 3> opposite{tet[static_cast<std::size_t>(face[0])],
                                      tet[static_cast<std::size_t>(face[1])],
                                      tet[static_cast<std::size_t>(face[2])]};
  const std::size_t at_b = opposite[0] == b ? 0U : (opposite[1] == b ? 1U : 2U);
  return {opposite[(at_b + 1) % 3], opposite[(at_b + 2) % 3]};
}

}  // namespace

double score_tet(const ScoreScale& scale, const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  static thread_local Cone cone;
  cone.clear();
  cone.add(b, c, d);
  return cone.evaluate(scale, a, -1e300).worst;
}

bool find_edge_ring(const WorkingMesh& mesh, Index a, Index b, EdgeRing& ring) {
  std::array<std::array<Index, 2>, kLargestRing> pairs{};
  std::array<Index, kLargestRing> tets{};
  std::size_t n = 0;
  const Index around = mesh.star_size[b] < mesh.star_size[a] ? b : a;
  const Index other = around == a ? b : a;
  for (const Index t : mesh.star(around)) {
    if (corners_that_are(mesh.tets[t], other) == 0U) continue;
    if (n == kLargestRing || mesh.is_kept(t)) return false;
    pairs[n] = ring_pair(mesh.tets[t], a, b);
    tets[n++] = t;
  }
  if (n < 3) return false;
  for (std::size_t i = 0; i + 1 < n; ++i) {  // bring the successor of pair i behind it
    std::size_t j = i + 1;
    while (j < n && pairs[j][0] != pairs[i][1]) ++j;
    if (j == n) return false;
    std::swap(pairs[i + 1], pairs[j]);
    std::swap(tets[i + 1], tets[j]);
  }
  if (pairs[n - 1][1] != pairs[0][0]) return false;
  ring.a = a;
  ring.b = b;
  ring.size = n;
  for (std::size_t i = 0; i < n; ++i) {
    ring.ring[i] = pairs[i][0];
    ring.tets[i] = tets[i];
  }
  return true;
}

double Flipper::known_score(Index t) {
  double& score = mesh_.score[t];
  if (score < 0.0) {
    const Tet& tet = mesh_.tets[t];
    score = score_tet(rule_.scale, mesh_.points[tet[0]], mesh_.points[tet[1]], mesh_.points[tet[2]],
                      mesh_.points[tet[3]]);
  }
  return score;
}

bool Flipper::try_remove_edge(Index a, Index b) {
  EdgeRing ring;
  if (!find_edge_ring(mesh_, a, b, ring)) return false;
  const std::size_t n = ring.size;
  const std::size_t after = mesh_.alive + n - 4;
  if (after > rule_.most_tets || after < rule_.fewest_tets) return false;
  double old_sum = 0.0;
  double old_worst = 1e300;
  for (std::size_t i = 0; i < n; ++i) {
    const double s = known_score(ring.tets[i]);
    old_sum += gain_of_score(s) - rule_.mean_gain;
    old_worst = std::min(old_worst, s);
  }
  // All triangles (i, k, j), i < k < j, of the ring, as tets below b and above a.
  std::array<std::array<std::array<std::size_t, kLargestRing>, kLargestRing>, kLargestRing> number{};
  cone_.clear();
  for (std::size_t i = 0; i + 2 < n; ++i) {
    for (std::size_t k = i + 1; k + 1 < n; ++k) {
      for (std::size_t j = k + 1; j < n; ++j) {
        number[i][k][j] = cone_.size();
        cone_.add(mesh_.points[ring.ring[i]], mesh_.points[ring.ring[k]], mesh_.points[ring.ring[j]]);
      }
    }
  }
  cone_.scores(rule_.scale, mesh_.points[a], scores_a_);
  // From b the triangles are seen from the other side: swap by mirroring the sign.
  cone_.scores_from_behind(rule_.scale, mesh_.points[b], scores_b_);
  constexpr double kNone = -1e300;
  std::array<std::array<double, kLargestRing>, kLargestRing> best{};
  std::array<std::array<std::size_t, kLargestRing>, kLargestRing> split{};
  for (std::size_t width = 2; width < n; ++width) {
    for (std::size_t i = 0; i + width < n; ++i) {
      const std::size_t j = i + width;
      best[i][j] = kNone;
      for (std::size_t k = i + 1; k < j; ++k) {
        const std::size_t at = number[i][k][j];
        const double worst = std::min(scores_a_[at], scores_b_[at]);
        if (worst < kSafeScore || worst < 0.5 * old_worst) continue;
        if (best[i][k] == kNone || best[k][j] == kNone) continue;
        const double sum = best[i][k] + best[k][j] + gain_of_score(scores_a_[at]) +
                           gain_of_score(scores_b_[at]) - 2.0 * rule_.mean_gain;
        if (sum > best[i][j]) {
          best[i][j] = sum;
          split[i][j] = k;
        }
      }
    }
  }
  if (!(best[0][n - 1] > old_sum + 1e-6)) return false;
  fresh_.clear();
  std::array<double, 4 * kLargestRing> fresh_scores{};
  std::array<std::array<std::size_t, 2>, kLargestRing> open{};
  std::size_t depth = 0;
  open[depth++] = {0, n - 1};
  while (depth > 0) {
    const auto [i, j] = open[--depth];
    if (j < i + 2) continue;
    const std::size_t k = split[i][j];
    const std::size_t at = number[i][k][j];
    fresh_scores[fresh_.size()] = scores_a_[at];
    fresh_.push_back({a, ring.ring[i], ring.ring[k], ring.ring[j]});
    fresh_scores[fresh_.size()] = scores_b_[at];
    fresh_.push_back({b, ring.ring[i], ring.ring[j], ring.ring[k]});
    open[depth++] = {i, k};
    open[depth++] = {k, j};
  }
  apply_flip(mesh_, {ring.tets.data(), n}, fresh_, added_);
  for (std::size_t i = 0; i < added_.size(); ++i) mesh_.score[added_[i]] = fresh_scores[i];
  return true;
}

bool Flipper::try_remove_face(Index tet, std::size_t corner) {
  if (mesh_.alive + 1 > rule_.most_tets) return false;
  const Tet t = mesh_.tets[tet];
  const auto& face = kTetFaces[corner];
  const Index p = t[corner];
  const Index a = t[static_cast<std::size_t>(face[0])];
  const Index b = t[static_cast<std::size_t>(face[1])];
  const Index c = t[static_cast<std::size_t>(face[2])];  // (p, a, b, c) is positive
  const Index other = neighbour_across(mesh_, tet, a, b, c);
  if (other == kNoIndex || mesh_.is_kept(tet) || mesh_.is_kept(other)) return false;
  Index q = kNoIndex;
  for (const Index v : mesh_.tets[other]) {
    if (v != a && v != b && v != c) q = v;
  }
  const double s0 = known_score(tet);
  const double s1 = known_score(other);
  const double old_worst = std::min(s0, s1);
  const double old_sum = gain_of_score(s0) + gain_of_score(s1) + rule_.mean_gain;
  // (p, a, b, q), (p, b, c, q), (p, c, a, q)
  cone_.clear();
  cone_.add(mesh_.points[a], mesh_.points[b], mesh_.points[q]);
  cone_.add(mesh_.points[b], mesh_.points[c], mesh_.points[q]);
  cone_.add(mesh_.points[c], mesh_.points[a], mesh_.points[q]);
  const double least = std::max(kSafeScore, 0.5 * old_worst);
  const ConeFigures then = cone_.evaluate(rule_.scale, mesh_.points[p], least);
  if (then.worst < least || !(then.sum > old_sum + 1e-6)) return false;
  cone_.scores(rule_.scale, mesh_.points[p], scores_a_);
  const std::array<Index, 2> old{tet, other};
  const std::array<Tet, 3> fresh{{{p, a, b, q}, {p, b, c, q}, {p, c, a, q}}};
  apply_flip(mesh_, old, fresh, added_);
  for (std::size_t i = 0; i < 3; ++i) mesh_.score[added_[i]] = scores_a_[i];
  return true;
}

}  // namespace palpate::simplify

#include "core/simplify/tet_operations/shortest_edges.h"

#include <algorithm>
#include <array>
#include <limits>

#include "core/simplify/fusion/fusion.h"

namespace palpate::simplify {
namespace {

/// Each further batch is so many times as large as the one before, so that the mesh is walked a few times at
/// most.
constexpr std::size_t kGrowth = 8;

/// What is too long for a batch is known from a sample of the tets: each so many-th, or fewer of a large
/// mesh.
constexpr std::size_t kLeastStride = 8;
constexpr std::size_t kTetsOfSample = 4096;
constexpr double kEdgesPerTet = 1.2;
constexpr double kEdgesPerBatch = 1.4;    ///< as many as a batch and a margin
constexpr double kMostOfSample = 0.7;     ///< a limit that leaves less out is none
constexpr double kKeysAreLess = 1e-9;     ///< than squared lengths, by rounding
constexpr double kFewEdgesPerTet = 0.02;  ///< a batch of so few is found in the tets, not in the stars

constexpr double kNoLimit = std::numeric_limits<double>::infinity();

/// What the squared length of an edge with at most this key is at most: relative sizes are no more than 1.
double most_squared(double key) {
  return key * (1.0 + kKeysAreLess);
}

/// The order of std heaps is that of sizes turned round: the edge that comes first is the greatest.
bool comes_before(const WaitingEdge& a, const WaitingEdge& b) {
  return b < a;
}

}  // namespace

void collect_neighbours(const WorkingMesh& mesh, Index v, VertexMarks& marks, std::vector<Index>& neighbours,
                        Index least) {
  marks.clear(mesh.points.size());
  marks.set(v, 1);
  neighbours.clear();
  for (const Index t : mesh.star(v)) {
    for (const Index w : mesh.tets[t]) {
      if (w < least || marks.of(w) != 0) continue;
      marks.set(w, 1);
      neighbours.push_back(w);
    }
  }
}

ShortestEdges::ShortestEdges(const WorkingMesh& mesh, const SizingField& field, std::size_t first_batch)
    : mesh_(mesh), field_(field), batch_(first_batch), last_(mesh.points.size(), 0) {}

WaitingEdge ShortestEdges::edge_between(Index a, Index b) const {
  if (last_[a] != last_[b] ? last_[a] < last_[b] : b < a) std::swap(a, b);
  return {key_of_edge(mesh_, field_, a, b), a, b, last_[a] + last_[b]};
}

/// Keeps the first `count` of those that wait; the others are in the mesh.
void ShortestEdges::keep_first(std::size_t count) {
  const auto last = waiting_.begin() + static_cast<std::ptrdiff_t>(count) - 1;
  std::nth_element(waiting_.begin(), last, waiting_.end(), comes_before);
  bound_ = *last;
  waiting_.erase(last + 1, waiting_.end());
}

/// Holds an edge that comes behind `before_`, unless a batch is held that comes before it.
void ShortestEdges::take(const WaitingEdge& edge) {
  if (before_ && !comes_before(*before_, edge)) return;
  if (!is_complete_ && !comes_before(edge, *bound_)) return;
  waiting_.push_back(edge);
  if (waiting_.size() < 2 * batch_) return;
  keep_first(batch_);
  is_complete_ = false;
}

/// A key that, judging by a sample, a batch of edges behind `before_` and some more do not exceed. Infinite
/// where that would be most of them.
double ShortestEdges::estimate_limit() const {
  const std::size_t stride = std::max(kLeastStride, mesh_.tets.size() / kTetsOfSample);
  std::vector<double> keys;
  std::size_t seen = 0;
  for (std::size_t t = 0; t < mesh_.tets.size(); t += stride) {
    const Tet& tet = mesh_.tets[t];
    if (!mesh_.is_alive(static_cast<Index>(t))) continue;
    for (const auto& [i, j] : kTetEdges) {
      const Index a = tet[static_cast<std::size_t>(i)];
      const Index b = tet[static_cast<std::size_t>(j)];
      ++seen;
      if (!may_collapse(a, b)) continue;
      const double key = key_of_edge(mesh_, field_, a, b);
      if (!before_ || key >= before_->key) keys.push_back(key);
    }
  }
  const double wanted = kEdgesPerBatch * static_cast<double>(batch_);
  const double rank = wanted / (kEdgesPerTet * static_cast<double>(mesh_.alive)) * static_cast<double>(seen);
  if (!(rank < kMostOfSample * static_cast<double>(keys.size()))) return kNoLimit;
  const auto nth = keys.begin() + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(keys.begin(), nth, keys.end());
  return *nth;
}

/// Takes edges up to a key, each in the first of its tets in the star of its smaller end. For few edges: most
/// are left out by their length, without a look at stars.
void ShortestEdges::take_from_tets(double limit) {
  const auto is_first = [&](Index t, Index a, Index b) {
    const auto star = mesh_.star(a);
    return *std::find_if(star.begin(), star.end(),
                         [&](Index u) { return corners_that_are(mesh_.tets[u], b) != 0U; }) == t;
  };
  const double most = most_squared(limit);
  for (Index t = 0; t < mesh_.tets.size(); ++t) {
    if (!mesh_.is_alive(t)) continue;
    const Tet tet = mesh_.tets[t];
    const std::array<Vec3, 4> p{mesh_.points[tet[0]], mesh_.points[tet[1]], mesh_.points[tet[2]],
                                mesh_.points[tet[3]]};
    for (const auto& [i, j] : kTetEdges) {
      const auto first = static_cast<std::size_t>(i);
      const auto second = static_cast<std::size_t>(j);
      if (length_sq(p[second] - p[first]) > most) continue;
      const auto [a, b] = std::minmax(tet[first], tet[second]);
      if (!may_collapse(a, b) || !is_first(t, a, b)) continue;
      const WaitingEdge edge = edge_between(a, b);
      if (edge.key <= limit) take(edge);
    }
  }
}

/// Takes edges up to a key, each in the star of its smaller end.
void ShortestEdges::take_from_stars(double limit) {
  const double most = most_squared(limit);
  for (Index a = 0; a < mesh_.points.size(); ++a) {
    if (!mesh_.is_vertex_alive(a)) continue;
    collect_neighbours(mesh_, a, marks_, neighbours_, a + 1);
    const Vec3 at = mesh_.points[a];
    for (const Index b : neighbours_) {
      if (length_sq(mesh_.points[b] - at) > most || !may_collapse(a, b)) continue;
      const WaitingEdge edge = edge_between(a, b);
      if (edge.key <= limit) take(edge);
    }
  }
}

/// The first edges behind `bound_`, a batch of them. Returns whether there were any.
bool ShortestEdges::fill() {
  if (is_complete_) return false;
  before_ = bound_;
  is_complete_ = true;
  waiting_.clear();
  double limit = estimate_limit();
  const bool are_few = static_cast<double>(batch_) < kFewEdgesPerTet * static_cast<double>(mesh_.alive);
  if (are_few && limit < kNoLimit) {
    take_from_tets(limit);
  } else {
    take_from_stars(limit);
  }
  if (limit < kNoLimit && waiting_.size() < batch_) {  // the sample was misleading
    limit = kNoLimit;
    waiting_.clear();
    take_from_stars(limit);
  }
  if (limit < kNoLimit || waiting_.size() > batch_) {
    keep_first(batch_);
    is_complete_ = false;
  }
  batch_ *= kGrowth;
  std::make_heap(waiting_.begin(), waiting_.end());
  return !waiting_.empty();
}

std::optional<WaitingEdge> ShortestEdges::pop() {
  do {
    while (!waiting_.empty()) {
      std::pop_heap(waiting_.begin(), waiting_.end());
      const WaitingEdge edge = waiting_.back();
      waiting_.pop_back();
      if (!is_void(edge)) return edge;
    }
  } while (fill());
  return std::nullopt;
}

void ShortestEdges::start_over() {
  waiting_.swap(parked_);
  parked_.clear();
  is_complete_ = true;
  std::make_heap(waiting_.begin(), waiting_.end());
}

void ShortestEdges::drop_void() {
  std::erase_if(waiting_, [&](const WaitingEdge& edge) { return is_void(edge); });
  std::make_heap(waiting_.begin(), waiting_.end());
  if (2 * waiting_.size() > waiting_.capacity()) waiting_.reserve(2 * waiting_.capacity());
}

void ShortestEdges::renew(Index gone, Index survivor) {
  last_[gone] = last_[survivor] = ++collapses_;
  collect_neighbours(mesh_, survivor, marks_, neighbours_);
  for (const Index w : neighbours_) {
    if (!may_collapse(survivor, w)) continue;
    const WaitingEdge edge = edge_between(survivor, w);
    if (!is_complete_ && comes_before(*bound_, edge)) continue;
    if (waiting_.size() == waiting_.capacity()) drop_void();
    waiting_.push_back(edge);
    std::push_heap(waiting_.begin(), waiting_.end());
  }
}

}  // namespace palpate::simplify

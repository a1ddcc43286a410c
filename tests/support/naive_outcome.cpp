#include "tests/support/naive_outcome.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <set>

#include "core/mesh/geometry.h"
#include "core/mesh/orientation.h"
#include "core/simplify/batch_quality.h"

namespace palpate::test_support {
namespace {

using simplify::OutcomeOptions;

bool has(const Tet& tet, Index v) {
  return std::find(tet.begin(), tet.end(), v) != tet.end();
}

class Naive {
 public:
  Naive(const TetMesh& mesh, const OutcomeOptions& options)
      : mesh_(mesh),
        options_(options),
        sizing_(options.common.sizing, mesh),
        kept_(simplify::build_kept_vertices(simplify::build_kept_tets(sizing_, mesh), mesh)),
        alive_(mesh.tets.size(), true),
        touched_(mesh.tets.size(), false) {
    kept_.resize(mesh.points.size());
    tets_of_.resize(mesh.points.size());
    for (Index t = 0; t < mesh.tets.size(); ++t) {
      for (const Index v : mesh.tets[t]) tets_of_[v].insert(t);
    }
    count_ = mesh.tets.size();
    ideal_volume_ = total_volume(mesh) / static_cast<double>(count_);
    const auto work = simplify::build_fusion_mesh(TetMesh(mesh), simplify::StorageOrder::kInput);
    level_ = simplify::build_levels(work, build_boundary_vertex_flags(mesh), options.common.levels);
    double sum = 0.0;
    for (const Tet& t : mesh.tets) sum += quality(t, kNoIndex, {}).value();
    mean_quality_ = std::nearbyint(sum / static_cast<double>(count_) * 0x1p36) / 0x1p36;
  }

  std::uint64_t run() {
    const simplify::StopRule& stop = options_.common.stop;
    const std::uint64_t target = simplify::target_tet_count(stop, mesh_.tets.size());
    const int grading_passes = sizing_.near_size() == 1.0 ? 0 : 8;
    std::uint64_t fusions = 0;
    bool is_first = true;
    for (int pass = 0;; ++pass) {
      const bool is_graded = pass < grading_passes;
      largest_far_ = is_graded ? std::ldexp(ideal_volume_, pass) : std::numeric_limits<double>::infinity();
      if (options_.many_passes && !is_first) touched_.assign(touched_.size(), false);
      is_first = false;
      const std::uint64_t before = fusions;
      while (true) {
        if ((stop.fusions && fusions >= *stop.fusions) || count_ <= target) return fusions;
        const Index cheapest = find_cheapest();
        if (cheapest == kNoIndex) break;
        fuse(cheapest);
        ++fusions;
      }
      const bool goes_on = options_.common.skip_touched && options_.many_passes && fusions > before;
      if (!is_graded && !goes_on) return fusions;
    }
  }

  /// Alive tets in their order, and the vertices they use in theirs.
  TetMesh result() const {
    TetMesh out;
    std::vector<Index> number(mesh_.points.size(), kNoIndex);
    for (Index v = 0; v < mesh_.points.size(); ++v) {
      if (tets_of_[v].empty()) continue;
      number[v] = static_cast<Index>(out.points.size());
      out.points.push_back(mesh_.points[v]);
    }
    for (Index t = 0; t < mesh_.tets.size(); ++t) {
      if (!alive_[t]) continue;
      Tet tet = mesh_.tets[t];
      for (Index& v : tet) v = number[v];
      out.tets.push_back(tet);
    }
    return out;
  }

 private:
  /// Nothing if the tet is not positive once `from` has moved to `to`.
  std::optional<double> quality(const Tet& t, Index from, const Vec3& to) const {
    std::array<Vec3, 4> p;
    for (std::size_t i = 0; i < 4; ++i) p[i] = t[i] == from ? to : mesh_.points[t[i]];
    if (orientation(p[0], p[1], p[2], p[3]) <= 0) return std::nullopt;
    simplify::TetBatch batch;
    batch.add(p[0], p[1], p[2], p[3]);
    simplify::measure_batch(options_.common.metric, ideal_volume_, batch);
    return batch.quality[0];
  }

  std::set<Index> around(Index t) const {
    std::set<Index> all;
    for (const Index v : mesh_.tets[t]) all.insert(tets_of_[v].begin(), tets_of_[v].end());
    return all;
  }

  std::vector<Index> shared_vertices(Index t, Index other) const {
    std::vector<Index> shared;
    for (const Index v : mesh_.tets[other]) {
      if (has(mesh_.tets[t], v)) shared.push_back(v);
    }
    return shared;
  }

  Vec3 barycenter(Index t) const {
    const Tet& v = mesh_.tets[t];
    return 0.25 * (mesh_.points[v[0]] + mesh_.points[v[1]] + mesh_.points[v[2]] + mesh_.points[v[3]]);
  }

  /// Nothing if a check fails.
  std::optional<double> cost(Index t) const {
    const Vec3 center = barycenter(t);
    double lost = 0.0;
    int removed = 0;
    for (const Index other : around(t)) {
      const std::vector<Index> shared = shared_vertices(t, other);
      const double before = quality(mesh_.tets[other], kNoIndex, {}).value();
      if (shared.size() == 1) {
        const std::optional<double> after = quality(mesh_.tets[other], shared[0], center);
        if (!after || *after < options_.common.drop * before) return std::nullopt;
        lost += before - *after;
      } else {
        ++removed;
        if (options_.objective == simplify::OutcomeObjective::kTotalLoss) lost += before - mean_quality_;
      }
    }
    return lost / removed;
  }

  bool is_candidate(Index t) const {
    const Tet& tet = mesh_.tets[t];
    if (!alive_[t] || level_[t] == simplify::kNoLevel || level_[t] < options_.common.last_level) return false;
    if (options_.common.skip_touched && touched_[t]) return false;
    if (std::any_of(tet.begin(), tet.end(), [&](Index v) { return kept_[v] != 0; })) return false;
    if (largest_far_ == std::numeric_limits<double>::infinity()) return true;
    const double size = sizing_.relative_size(barycenter(t));
    const double volume =
        signed_volume(mesh_.points[tet[0]], mesh_.points[tet[1]], mesh_.points[tet[2]], mesh_.points[tet[3]]);
    return volume < size * size * size * largest_far_;
  }

  Index find_cheapest() const {
    Index cheapest = kNoIndex;
    double least = 0.0;
    for (Index t = 0; t < mesh_.tets.size(); ++t) {
      if (!is_candidate(t)) continue;
      const std::optional<double> own = cost(t);
      if (!own || (cheapest != kNoIndex && *own >= least)) continue;
      cheapest = t;
      least = *own;
    }
    return cheapest;
  }

  void fuse(Index t) {
    const Tet center = mesh_.tets[t];
    const Vec3 point = barycenter(t);
    const Index survivor = *std::min_element(center.begin(), center.end());
    std::set<Index> moved;
    for (const Index other : around(t)) {
      if (shared_vertices(t, other).size() == 1) {
        moved.insert(other);
        touched_[other] = true;
      } else {
        alive_[other] = false;
        --count_;
      }
    }
    for (Index other = 0; other < alive_.size(); ++other) {
      if (alive_[other]) continue;
      for (const Index v : mesh_.tets[other]) tets_of_[v].erase(other);
    }
    for (const Index v : center) tets_of_[v].clear();
    mesh_.points[survivor] = point;
    tets_of_[survivor] = moved;
    for (const Index other : moved) {
      for (Index& v : mesh_.tets[other]) v = has(center, v) ? survivor : v;
    }
  }

  TetMesh mesh_;
  OutcomeOptions options_;
  simplify::SizingField sizing_;
  std::vector<std::uint8_t> kept_;
  double largest_far_ = 0.0;
  std::vector<bool> alive_;
  std::vector<bool> touched_;
  std::vector<std::set<Index>> tets_of_;
  std::vector<std::uint16_t> level_;
  std::size_t count_ = 0;
  double ideal_volume_ = 0.0;
  double mean_quality_ = 0.0;
};

}  // namespace

std::uint64_t simplify_naively_by_outcome(TetMesh& mesh, const OutcomeOptions& options) {
  Naive naive(mesh, options);
  const std::uint64_t fusions = naive.run();
  mesh = naive.result();
  return fusions;
}

}  // namespace palpate::test_support

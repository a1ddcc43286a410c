#include "tests/support/naive_cheapest_first.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "core/mesh/geometry.h"
#include "core/mesh/orientation.h"
#include "core/simplify/quality/batch_quality.h"

namespace palpate::test_support {
namespace {

using simplify::CheapestFirstOptions;

bool has(const Tet& tet, Index v) {
  return std::find(tet.begin(), tet.end(), v) != tet.end();
}

class Naive {
 public:
  Naive(const TetMesh& mesh, const CheapestFirstOptions& options)
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
    mean_quality_ = on_grid(sum / static_cast<double>(count_));
  }

  std::uint64_t run() {
    std::uint64_t fusions = 0;
    for (int pass = 0; pass < (sizing_.near_size() == 1.0 ? 0 : 8); ++pass) {
      largest_far_ = ideal_volume_ * static_cast<double>(1U << static_cast<unsigned>(pass));
      fuse_all(fusions);
    }
    largest_far_ = 0.0;
    fuse_all(fusions);
    return fusions;
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
  void fuse_all(std::uint64_t& fusions) {
    const std::uint64_t target = simplify::target_tet_count(options_.common.stop, mesh_.tets.size());
    std::uint64_t at_start_of_pass = fusions;
    const bool clears_marks = options_.common.skip_touched && options_.many_passes;
    if (clears_marks) touched_.assign(touched_.size(), false);
    while (!(options_.common.stop.fusions && fusions >= *options_.common.stop.fusions) && count_ > target) {
      const Index cheapest = find_cheapest();
      if (cheapest != kNoIndex) {
        fuse(cheapest);
        ++fusions;
      } else if (clears_marks && fusions > at_start_of_pass) {
        touched_.assign(touched_.size(), false);
        at_start_of_pass = fusions;
      } else {
        break;
      }
    }
  }

  bool has_kept_vertex(Index t) const {
    return std::any_of(mesh_.tets[t].begin(), mesh_.tets[t].end(), [&](Index v) { return kept_[v] != 0; });
  }

  /// Smaller than the sizing field lets it grow in this pass? Always, without a bound.
  bool may_grow(Index t) const {
    if (largest_far_ == 0.0) return true;
    const Tet& v = mesh_.tets[t];
    const double volume =
        signed_volume(mesh_.points[v[0]], mesh_.points[v[1]], mesh_.points[v[2]], mesh_.points[v[3]]);
    const double size = sizing_.relative_size(barycenter(t));
    return volume < size * size * size * largest_far_;
  }

  static double on_grid(double q) { return std::nearbyint(q * 0x1p36) / 0x1p36; }

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
        if (options_.objective == simplify::CostObjective::kTotalLoss) lost += before - mean_quality_;
      }
    }
    return lost / removed;
  }

  Index find_cheapest() const {
    Index cheapest = kNoIndex;
    double least = 0.0;
    for (Index t = 0; t < mesh_.tets.size(); ++t) {
      if (!alive_[t] || level_[t] == simplify::kNoLevel || level_[t] < options_.common.last_level) continue;
      if (options_.common.skip_touched && touched_[t]) continue;
      if (has_kept_vertex(t) || !may_grow(t)) continue;
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
  CheapestFirstOptions options_;
  simplify::SizingField sizing_;
  std::vector<std::uint8_t> kept_;
  double largest_far_ = 0.0;  ///< 0: no bound
  std::vector<bool> alive_;
  std::vector<bool> touched_;
  std::vector<std::set<Index>> tets_of_;
  std::vector<std::uint16_t> level_;
  std::size_t count_ = 0;
  double ideal_volume_ = 0.0;
  double mean_quality_ = 0.0;
};

}  // namespace

std::uint64_t simplify_naively_cheapest_first(TetMesh& mesh, const CheapestFirstOptions& options) {
  Naive naive(mesh, options);
  const std::uint64_t fusions = naive.run();
  mesh = naive.result();
  return fusions;
}

}  // namespace palpate::test_support

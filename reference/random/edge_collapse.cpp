#include "reference/random/edge_collapse.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "core/base/random.h"
#include "core/mesh/orientation.h"
#include "core/mesh/topology.h"
#include "core/simplify/quality/quality.h"

namespace palpate::reference {
namespace {

constexpr simplify::QualityMetric kMetric{simplify::thesis_shape, false};

bool has(const Tet& tet, Index v) {
  return std::find(tet.begin(), tet.end(), v) != tet.end();
}

/// A collapse: `removed` goes into `kept`, which moves to `position`.
struct Collapse {
  Index kept = kNoIndex;
  Index removed = kNoIndex;
  Vec3 position;
  double worst = 0.0;  ///< shape of the worst tet that it leaves around `kept`
};

class Collapser {
 public:
  Collapser(TetMesh& mesh, const EdgeCollapseOptions& options)
      : mesh_(mesh),
        options_(options),
        random_(options.seed),
        on_boundary_(build_boundary_vertex_flags(mesh)),
        stars_(mesh.points.size()),
        alive_(mesh.tets.size()),
        place_(mesh.tets.size()),
        shape_(mesh.tets.size()) {
    for (Index t = 0; t < mesh.tets.size(); ++t) {
      for (const Index v : mesh.tets[t]) stars_[v].push_back(t);
      alive_[t] = place_[t] = t;
      shape_[t] = *shape_after(mesh.tets[t], kNoIndex, {});
    }
  }

  EdgeCollapseReport run() {
    bool is_last = false;
    for (int step = 0; !is_last && !is_done(); ++step) {
      // The margin lets the steps from first to last come out whole despite their rounding.
      const double next = options_.first_guard - (step + 1) * kGuardStep;
      is_last = next < options_.last_guard - 1e-9;
      const double guard = options_.first_guard - step * kGuardStep;
      least_shape_ = guard * guard * guard;
      while (!is_done()) {
        const double rate = run_round();
        if (rate == 0.0 || (!is_last && rate < kWorthwhileRate)) break;
      }
    }
    report_.reached_target = is_done() && options_.target_tets > 0;
    return report_;
  }

  /// The alive tets in their order, and the vertices they use in theirs.
  TetMesh result() {
    std::sort(alive_.begin(), alive_.end());
    TetMesh out;
    std::vector<Index> number(mesh_.points.size(), kNoIndex);
    for (Index v = 0; v < mesh_.points.size(); ++v) {
      if (stars_[v].empty()) continue;
      number[v] = static_cast<Index>(out.points.size());
      out.points.push_back(mesh_.points[v]);
    }
    out.tets.reserve(alive_.size());
    for (const Index t : alive_) {
      const Tet& tet = mesh_.tets[t];
      out.tets.push_back({number[tet[0]], number[tet[1]], number[tet[2]], number[tet[3]]});
    }
    return out;
  }

 private:
  /// The cubed quality of a tet with vertex `moved` at `position`; nothing unless it is positive.
  std::optional<double> shape_after(const Tet& tet, Index moved, const Vec3& position) const {
    std::array<Vec3, 4> p;
    for (std::size_t k = 0; k < 4; ++k) p[k] = tet[k] == moved ? position : mesh_.points[tet[k]];
    const simplify::TetFigures figures = simplify::measure_tet(kMetric, p[0], p[1], p[2], p[3]);
    return figures.is_positive ? std::optional(figures.shape) : std::nullopt;
  }

  /// A random edge of a random tet, weighed.
  std::optional<Collapse> draw() {
    constexpr std::array<std::array<std::size_t, 2>, 6> kEdges{
        {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}};
    const Tet& tet = mesh_.tets[alive_[random_.below(alive_.size())]];
    const auto [i, j] = kEdges[random_.below(kEdges.size())];
    Index kept = tet[i];
    Index removed = tet[j];
    if (on_boundary_[removed] != 0) std::swap(kept, removed);
    if (on_boundary_[removed] != 0) {
      ++report_.refused_boundary;
      return std::nullopt;
    }
    return weigh(kept, removed);
  }

  std::optional<Collapse> weigh(Index kept, Index removed) {
    double worst_before = std::numeric_limits<double>::infinity();
    for (const Index v : {kept, removed}) {
      for (const Index t : stars_[v]) worst_before = std::min(worst_before, shape_[t]);
    }
    const double bound = std::min(worst_before, least_shape_);
    const Vec3& a = mesh_.points[kept];
    const Vec3& b = mesh_.points[removed];
    std::optional<Collapse> best;
    bool flips = true;
    const auto try_at = [&](const Vec3& position) {
      const double least = best ? std::nextafter(best->worst, 2.0) : bound;
      const Outcome outcome = find_worst(kept, removed, position, least);
      flips = flips && outcome.flips;
      if (outcome.worst >= least) best = {kept, removed, position, outcome.worst};
    };
    if (on_boundary_[kept] != 0) {
      try_at(a);
    } else {
      try_at(0.5 * (a + b));
      if (options_.placement == Placement::kBest) {
        try_at(a);
        try_at(b);
      }
    }
    if (!best) ++(flips ? report_.refused_flip : report_.refused_quality);
    return best;
  }

  bool is_done() const { return alive_.size() <= options_.target_tets; }

  /// As many draws as there are tets, or up to the target. Returns: collapses a draw.
  double run_round() {
    const auto draws = static_cast<std::uint64_t>(alive_.size());
    const std::uint64_t collapses_before = report_.collapses;
    for (std::uint64_t n = 0; n < draws && !is_done(); n += static_cast<std::uint64_t>(options_.candidates)) {
      std::optional<Collapse> best;
      for (int k = 0; k < options_.candidates; ++k) {
        const std::optional<Collapse> drawn = draw();
        if (drawn && (!best || drawn->worst > best->worst)) best = drawn;
      }
      if (best) carry_out(*best);
    }
    return static_cast<double>(report_.collapses - collapses_before) / static_cast<double>(draws);
  }

  struct Outcome {
    double worst = -1.0;  ///< -1: flips, or below the bound
    bool flips = false;
  };

  /// The worst shape around after a collapse; ends as soon as it falls below `bound`.
  Outcome find_worst(Index kept, Index removed, const Vec3& position, double bound) const {
    double worst = std::numeric_limits<double>::infinity();
    for (const Index v : {removed, kept}) {
      for (const Index t : stars_[v]) {
        const Tet& tet = mesh_.tets[t];
        if (has(tet, v == removed ? kept : removed)) continue;
        const std::optional<double> shape = shape_after(tet, v, position);
        if (!shape) return {-1.0, true};
        worst = std::min(worst, *shape);
        if (worst < bound) return {-1.0, false};
      }
    }
    return {worst, false};
  }

  void carry_out(const Collapse& collapse) {
    const Index kept = collapse.kept;
    const Index removed = collapse.removed;
    mesh_.points[kept] = collapse.position;
    for (const Index t : stars_[removed]) {
      Tet& tet = mesh_.tets[t];
      if (has(tet, kept)) {
        for (const Index v : tet) {
          if (v != removed) std::erase(stars_[v], t);
        }
        drop(t);
      } else {
        std::replace(tet.begin(), tet.end(), removed, kept);
        stars_[kept].push_back(t);
      }
    }
    stars_[removed] = {};
    for (const Index t : stars_[kept]) shape_[t] = *shape_after(mesh_.tets[t], kNoIndex, {});
    ++report_.collapses;
  }

  void drop(Index t) {
    const Index last = alive_.back();
    alive_[place_[t]] = last;
    place_[last] = place_[t];
    alive_.pop_back();
  }

  TetMesh& mesh_;
  const EdgeCollapseOptions& options_;
  SplitMix64 random_;
  std::vector<std::uint8_t> on_boundary_;
  std::vector<std::vector<Index>> stars_;  ///< alive tets of each vertex
  std::vector<Index> alive_;               ///< alive tets, for drawing
  std::vector<Index> place_;               ///< of each alive tet in alive_
  std::vector<double> shape_;              ///< cubed quality of each alive tet
  double least_shape_ = 0.0;               ///< cubed guard
  EdgeCollapseReport report_;
};

}  // namespace

EdgeCollapseReport collapse_random_edges(TetMesh& mesh, const EdgeCollapseOptions& options) {
  Collapser collapser(mesh, options);
  const EdgeCollapseReport report = collapser.run();
  mesh = collapser.result();
  return report;
}

}  // namespace palpate::reference

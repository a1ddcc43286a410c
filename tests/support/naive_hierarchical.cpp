#include "tests/support/naive_hierarchical.h"

#include <algorithm>
#include <map>
#include <set>

#include "core/mesh/geometry.h"
#include "core/mesh/orientation.h"

namespace palpate::test_support {
namespace {

using simplify::LevelAdjacency;
using simplify::SimplifyOptions;
using simplify::TetFigures;

int count_shared(const Tet& a, const Tet& b) {
  return static_cast<int>(
      std::count_if(a.begin(), a.end(), [&](Index v) { return std::count(b.begin(), b.end(), v); }));
}

class NaiveHierarchical {
 public:
  NaiveHierarchical(const TetMesh& mesh, const SimplifyOptions& options)
      : mesh_(mesh),
        options_(options),
        sizing_(options.sizing, mesh),
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
    total_volume_ = ideal_volume_ * static_cast<double>(count_);
    find_levels();
  }

  NaiveReport run() {
    NaiveReport report;
    const double mean_volume = ideal_volume_;
    for (int pass = 0; pass < (sizing_.near_size() == 1.0 ? 0 : 8); ++pass) {
      largest_far_ = mean_volume * static_cast<double>(1U << static_cast<unsigned>(pass));
      if (!run_levels(report)) return report;
    }
    largest_far_ = 0.0;
    if (!run_levels(report)) return report;
    for (Index t = 0; t < mesh_.tets.size(); ++t) {
      report.refused +=
          static_cast<std::uint64_t>(alive_[t] && level_[t] >= options_.last_level && !has_kept_vertex(t));
    }
    return report;
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
  /// All levels once. Returns whether it went to the end.
  bool run_levels(NaiveReport& report) {
    const std::uint64_t target = simplify::target_tet_count(options_.stop, mesh_.tets.size());
    const int highest = *std::max_element(level_.begin(), level_.end());
    for (int level = highest; level >= options_.last_level; --level) {
      while (true) {
        const bool stop =
            (options_.stop.fusions && report.fusions >= *options_.stop.fusions) || count_ <= target;
        if (stop) return false;
        const Index worst = find_worst(level);
        if (worst == kNoIndex) break;
        fuse(worst);
        ++report.fusions;
      }
    }
    return true;
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

  void find_levels() {
    std::map<std::set<Index>, int> face_count;
    for (const Tet& t : mesh_.tets) {
      for (const Index v : t) {
        std::set<Index> face(t.begin(), t.end());
        face.erase(v);
        ++face_count[face];
      }
    }
    std::set<Index> boundary;
    for (const auto& [face, count] : face_count) {
      if (count == 1) boundary.insert(face.begin(), face.end());
    }
    const int least_shared = options_.levels == LevelAdjacency::kVertex ? 1
                             : options_.levels == LevelAdjacency::kEdge ? 2
                                                                        : 3;
    level_.assign(mesh_.tets.size(), -1);
    for (Index t = 0; t < mesh_.tets.size(); ++t) {
      for (const Index v : mesh_.tets[t]) {
        if (boundary.count(v) > 0) level_[t] = 0;
      }
    }
    bool changed = true;
    for (int n = 0; changed; ++n) {
      changed = false;
      for (Index t = 0; t < mesh_.tets.size(); ++t) {
        if (level_[t] != -1) continue;
        for (const Index v : mesh_.tets[t]) {
          for (const Index other : tets_of_[v]) {
            if (level_[other] == n && count_shared(mesh_.tets[t], mesh_.tets[other]) >= least_shared)
              level_[t] = n + 1;
          }
        }
        changed = changed || level_[t] == n + 1;
      }
    }
  }

  TetFigures measure(const Tet& t, Index moved_from, const Vec3& to) const {
    std::array<Vec3, 4> p;
    for (std::size_t i = 0; i < 4; ++i) p[i] = t[i] == moved_from ? to : mesh_.points[t[i]];
    return simplify::measure_tet(options_.metric, p[0], p[1], p[2], p[3]);
  }

  double key(const TetFigures& f) const {
    return simplify::quality_key(options_.metric, f.shape, f.volume, ideal_volume_);
  }

  Vec3 barycenter(Index t) const {
    const Tet& v = mesh_.tets[t];
    return 0.25 * (mesh_.points[v[0]] + mesh_.points[v[1]] + mesh_.points[v[2]] + mesh_.points[v[3]]);
  }

  std::set<Index> around(Index t) const {
    std::set<Index> all;
    for (const Index v : mesh_.tets[t]) all.insert(tets_of_[v].begin(), tets_of_[v].end());
    return all;
  }

  bool is_suitable(Index t) const {
    const Vec3 center = barycenter(t);
    const double drop_cubed = options_.drop * options_.drop * options_.drop;
    for (const Index other : around(t)) {
      const Tet& tet = mesh_.tets[other];
      if (count_shared(tet, mesh_.tets[t]) != 1) continue;
      const Index shared = *std::find_if(tet.begin(), tet.end(), [&](Index v) {
        return std::count(mesh_.tets[t].begin(), mesh_.tets[t].end(), v) > 0;
      });
      const TetFigures after = measure(tet, shared, center);
      if (options_.checks.flip && !after.is_positive) return false;
      if (options_.checks.quality && key(after) < drop_cubed * key(measure(tet, kNoIndex, {}))) return false;
    }
    return true;
  }

  Index find_worst(int level) const {
    Index worst = kNoIndex;
    double worst_key = 0.0;
    for (Index t = 0; t < mesh_.tets.size(); ++t) {
      if (!alive_[t] || level_[t] != level || (options_.skip_touched && touched_[t])) continue;
      if (has_kept_vertex(t) || !may_grow(t)) continue;
      const double own = key(measure(mesh_.tets[t], kNoIndex, {}));
      if (worst != kNoIndex && own >= worst_key) continue;
      if (!is_suitable(t)) continue;
      worst = t;
      worst_key = own;
    }
    return worst;
  }

  void fuse(Index t) {
    const Tet center = mesh_.tets[t];
    const Vec3 point = barycenter(t);
    const Index survivor = *std::min_element(center.begin(), center.end());
    std::set<Index> moved;
    for (const Index other : around(t)) {
      if (count_shared(mesh_.tets[other], center) == 1) {
        moved.insert(other);
        touched_[other] = true;
      } else {
        alive_[other] = false;
        --count_;
        for (const Index v : mesh_.tets[other]) tets_of_[v].erase(other);
      }
    }
    for (const Index v : center) tets_of_[v].clear();
    mesh_.points[survivor] = point;
    tets_of_[survivor] = moved;
    for (const Index other : moved) {
      for (Index& v : mesh_.tets[other]) {
        if (std::count(center.begin(), center.end(), v) > 0) v = survivor;
      }
    }
    if (options_.ideal_volume == simplify::IdealVolume::kUpdated)
      ideal_volume_ = total_volume_ / static_cast<double>(count_);
  }

  TetMesh mesh_;
  SimplifyOptions options_;
  simplify::SizingField sizing_;
  std::vector<std::uint8_t> kept_;
  double largest_far_ = 0.0;  ///< 0: no bound
  std::vector<bool> alive_;
  std::vector<bool> touched_;
  std::vector<std::set<Index>> tets_of_;
  std::vector<int> level_;
  std::size_t count_ = 0;
  double ideal_volume_ = 0.0;
  double total_volume_ = 0.0;
};

}  // namespace

NaiveReport simplify_naively(TetMesh& mesh, const SimplifyOptions& options) {
  NaiveHierarchical naive(mesh, options);
  const NaiveReport report = naive.run();
  mesh = naive.result();
  return report;
}

}  // namespace palpate::test_support

#include "reference/tetfusion/sequential.h"

#include <algorithm>
#include <numeric>
#include <utility>
#include <vector>

#include "core/base/random.h"
#include "core/mesh/orientation.h"

namespace palpate::reference {
namespace {

using simplify::FusionMesh;
using simplify::FusionPlan;
using simplify::MovedTet;

/// The scan's order, as storage numbers.
std::vector<Index> build_scan(const FusionMesh& mesh, const SequentialOptions& options) {
  std::vector<Index> scan(mesh.tets.size());
  for (Index t = 0; t < mesh.tets.size(); ++t) scan[mesh.origin_of_tet(t)] = t;
  if (options.order == ScanOrder::kReverse) std::reverse(scan.begin(), scan.end());
  if (options.order == ScanOrder::kRandom) {
    SplitMix64 random(options.seed);
    shuffle(std::span<Index>(scan), random);
  }
  return scan;
}

enum class Check { kPassed, kFlip, kQuality };

/// Holds what a scan needs between tets.
class Scan {
 public:
  Scan(FusionMesh& mesh, std::vector<std::uint16_t> level, const SequentialOptions& options,
       double ideal_volume)
      : mesh_(mesh),
        options_(options.common),
        level_(std::move(level)),
        is_touched_(mesh.tets.size(), 0),
        target_(simplify::target_tet_count(options.common.stop, mesh.tets.size())),
        ideal_volume_(ideal_volume),
        total_volume_(ideal_volume * static_cast<double>(mesh.tets.size())),
        drop_cubed_(options_.drop * options_.drop * options_.drop) {}

  /// One scan. Returns how many tets it fused; sets report.stop when a stop was reached.
  std::uint64_t run_pass(const std::vector<Index>& scan, simplify::SimplifyReport& report) {
    report.rejected = {};
    std::fill(is_touched_.begin(), is_touched_.end(), std::uint8_t{0});
    const std::uint64_t fusions_before = report.fusions;
    for (const Index t : scan) {
      if (!mesh_.is_alive(t)) continue;
      if (level_[t] == 0) {
        ++report.rejected.boundary;
      } else if (level_[t] < options_.last_level) {
        ++report.rejected.boundary_neighbour;
      } else if (is_touched_[t] != 0) {
        ++report.rejected.touched;
      } else {
        if (is_at_stop(report)) break;
        const Check check = examine(t);
        if (check == Check::kPassed) {
          fuse();
          ++report.fusions;
        } else {
          ++(check == Check::kFlip ? report.rejected.flip : report.rejected.quality);
        }
      }
    }
    return report.fusions - fusions_before;
  }

  bool is_at_stop(simplify::SimplifyReport& report) const {
    const char* stop = simplify::reached_stop(options_.stop, target_, report.fusions, mesh_.alive);
    if (stop != nullptr) report.stop = stop;
    return report.stop != "limit";
  }

 private:
  double key_of(const simplify::TetFigures& figures) const {
    return simplify::quality_key(options_.metric, figures.shape, figures.volume, ideal_volume_);
  }

  Check examine(Index t) {
    const bool passes = simplify::walk_fusion(mesh_, t, plan_, [&](const MovedTet& m) {
      if (!options_.checks.flip) return true;
      const auto p = simplify::moved_points(mesh_, plan_, m);
      return orientation(p[0], p[1], p[2], p[3]) > 0;
    });
    if (!passes) return Check::kFlip;
    if (options_.checks.quality) {
      for (const MovedTet& m : plan_.moved) {
        const Tet& tet = mesh_.tets[m.tet];
        const auto after = simplify::moved_points(mesh_, plan_, m);
        const double key_before =
            key_of(simplify::measure_tet(options_.metric, mesh_.points[tet[0]], mesh_.points[tet[1]],
                                         mesh_.points[tet[2]], mesh_.points[tet[3]]));
        const double key_after =
            key_of(simplify::measure_tet(options_.metric, after[0], after[1], after[2], after[3]));
        if (key_after < drop_cubed_ * key_before) return Check::kQuality;
      }
    }
    return Check::kPassed;
  }

  void fuse() {
    simplify::apply_fusion(mesh_, plan_);
    if (options_.ideal_volume == simplify::IdealVolume::kUpdated) {
      ideal_volume_ = total_volume_ / static_cast<double>(mesh_.alive);
    }
    if (!options_.skip_touched) return;
    for (const MovedTet& m : plan_.moved) is_touched_[m.tet] = 1;
  }

  FusionMesh& mesh_;
  const simplify::SimplifyOptions& options_;
  std::vector<std::uint16_t> level_;
  std::vector<std::uint8_t> is_touched_;
  std::uint64_t target_;
  double ideal_volume_;
  double total_volume_;
  double drop_cubed_;
  FusionPlan plan_;
};

}  // namespace

simplify::SimplifyReport simplify_sequentially(TetMesh& mesh, const SequentialOptions& options) {
  simplify::validate_options(options.common);
  simplify::SimplifyReport report;
  report.vertices_in = mesh.points.size();
  report.tets_in = mesh.tets.size();
  report.stop = "limit";
  const double ideal_volume = simplify::mean_tet_volume(mesh);
  const std::vector<std::uint8_t> is_boundary = build_boundary_vertex_flags(mesh);
  FusionMesh work = simplify::build_fusion_mesh(std::move(mesh), options.common.storage);
  std::vector<std::uint16_t> level = simplify::build_levels(work, is_boundary, options.common.levels);
  report.level_sizes = simplify::count_levels(level);
  const std::vector<Index> scan = build_scan(work, options);
  Scan state(work, std::move(level), options, ideal_volume);
  while (state.run_pass(scan, report) > 0 && options.many_passes && report.stop == "limit") {
  }
  if (report.stop == "limit") state.is_at_stop(report);
  mesh = simplify::extract_mesh(std::move(work));
  report.vertices_out = mesh.points.size();
  report.tets_out = mesh.tets.size();
  return report;
}

}  // namespace palpate::reference

#include "core/simplify/fusion/fusion_driver.h"

#include <utility>

#include "core/simplify/fusion/levels.h"

namespace palpate::simplify {
namespace {

FusionStart make_ready(TetMesh&& mesh, const SimplifyOptions& options) {
  FusionStart start;
  start.ideal_volume = mean_tet_volume(mesh);
  start.sizing = SizingField(options.sizing, mesh);
  const std::vector<std::uint8_t> is_kept = build_kept_vertices(build_kept_tets(start.sizing, mesh), mesh);
  const std::vector<std::uint8_t> is_boundary = build_boundary_vertex_flags(mesh, options.threads);
  start.mesh = build_fusion_mesh(std::move(mesh), options.storage, options.threads);
  start.level = build_levels(start.mesh, is_boundary, options.levels);
  start.state.assign(start.mesh.tets.size(), State::kIdle);
  for (Index t = 0; t < start.state.size() && !is_kept.empty(); ++t) {
    if (has_flagged_vertex(start.mesh, t, is_kept)) start.state[t] = State::kKept;
  }
  return start;
}

Rejections count_rejections(const FusionStart& at_end, int last_level) {
  Rejections rejected;
  for (Index t = 0; t < at_end.mesh.tets.size(); ++t) {
    if (!at_end.mesh.is_alive(t)) continue;
    const State state = at_end.state[t];
    if (at_end.level[t] == 0) {
      ++rejected.boundary;
    } else if (at_end.level[t] < last_level) {
      ++rejected.boundary_neighbour;
    } else if (state == State::kTouched) {
      ++rejected.touched;
    } else if (state == State::kKept) {
      ++rejected.kept;
    } else if (state == State::kParkedFlip || state == State::kRefusedFlip) {
      ++rejected.flip;
    } else if (state == State::kParkedQuality || state == State::kRefusedQuality) {
      ++rejected.quality;
    }
  }
  return rejected;
}

}  // namespace

SimplifyReport simplify_by_fusions(TetMesh& mesh, const SimplifyOptions& options,
                                   const std::function<void(FusionStart&, SimplifyReport&)>& simplify) {
  SimplifyReport report;
  report.vertices_in = mesh.points.size();
  report.tets_in = mesh.tets.size();
  FusionStart start = make_ready(std::move(mesh), options);
  report.level_sizes = count_levels(start.level);
  simplify(start, report);
  report.rejected = count_rejections(start, options.last_level);
  mesh = extract_mesh(std::move(start.mesh));
  report.vertices_out = mesh.points.size();
  report.tets_out = mesh.tets.size();
  return report;
}

}  // namespace palpate::simplify

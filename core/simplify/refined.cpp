#include "core/simplify/refined.h"

#include <algorithm>
#include <utility>

#include "core/base/error.h"
#include "core/simplify/edge_removal.h"
#include "core/simplify/fusion.h"
#include "core/simplify/smoothing.h"

namespace palpate::simplify {
namespace {

struct Run {
  WorkingMesh mesh;
  const RefinedOptions& options;
  SizingField field;
  ScoreScale scale;
  FlipRule rule;
  RefinedReport report;
};

void flip_all(Run& run) {
  Flipper flipper(run.mesh, run.rule);
  const Index end = static_cast<Index>(run.mesh.tets.size());
  for (Index t = 0; t < end; ++t) {
    for (std::size_t e = 0; e < 6 && run.mesh.is_alive(t) && run.options.edge_removal; ++e) {
      const Tet tet = run.mesh.tets[t];
      const Index a = tet[static_cast<std::size_t>(kTetEdges[e][0])];
      const Index b = tet[static_cast<std::size_t>(kTetEdges[e][1])];
      if (flipper.try_remove_edge(a, b)) ++run.report.edges_removed;
    }
    for (std::size_t c = 0; c < 4 && run.mesh.is_alive(t) && run.options.face_removal; ++c) {
      if (flipper.try_remove_face(t, c)) ++run.report.faces_removed;
    }
  }
}

double mean_gain(WorkingMesh& mesh, const ScoreScale& scale) {
  double sum = 0.0;
  for (Index t = 0; t < mesh.tets.size(); ++t) {
    if (!mesh.is_alive(t)) continue;
    const Tet& tet = mesh.tets[t];
    mesh.score[t] =
        score_tet(scale, mesh.points[tet[0]], mesh.points[tet[1]], mesh.points[tet[2]], mesh.points[tet[3]]);
    sum += gain_of_score(mesh.score[t]);
  }
  return sum / static_cast<double>(std::max<std::size_t>(1, mesh.alive));
}

}  // namespace

void validate_options(const RefinedOptions& options) {
  if (options.stop.fusions) throw InputError("stop", 0, "tets, ratio or limit", "fusions");
  if (options.stop.ratio && !(*options.stop.ratio >= 0.0 && *options.stop.ratio < 1.0)) {
    throw InputError("ratio", 0, "a number in [0, 1)", std::to_string(*options.stop.ratio));
  }
  if (options.effort < 0 || options.effort > kMostEffort) {
    throw InputError("effort", 0, "0 to " + std::to_string(kMostEffort), std::to_string(options.effort));
  }
}

RefinedReport simplify_refined(TetMesh& mesh, const RefinedOptions& options) {
  validate_options(options);
  const std::uint64_t target = target_tet_count(options.stop, mesh.tets.size());
  const double volume = mean_tet_volume(mesh) * static_cast<double>(mesh.tets.size());
  RefinedReport report;
  report.vertices_in = mesh.points.size();
  report.tets_in = mesh.tets.size();
  SizingField field = options.sizing.keep.empty() ? SizingField() : SizingField(options.sizing, mesh);
  Run run{build_working_mesh(std::move(mesh), field), options, std::move(field), {}, {}, report};
  const double ideal = volume / static_cast<double>(std::max<std::uint64_t>(1, target));
  run.scale = {1.0 / (6.0 * ideal), 0.5};
  run.rule.scale = run.scale;
  run.rule.most_tets = std::max<std::uint64_t>(target, 1);
  run.rule.fewest_tets = static_cast<std::uint64_t>(static_cast<double>(target) * 0.995) + 1;
  CollapseOptions collapse;
  collapse.placement = options.collapse_placement;
  collapse.target = target;
  for (const double least : {0.03, 0.003, 1e-9}) {
    if (run.mesh.alive <= target) break;
    collapse.least_score = least;
    const CollapseReport c = collapse_edges(run.mesh, run.scale, run.field, collapse);
    run.report.collapses += c.collapses;
    run.report.rejected.rejected_link += c.rejected_link;
    run.report.rejected.rejected_shape += c.rejected_shape;
  }
  Smoother smoother(run.mesh, run.scale);
  run.rule.mean_gain = mean_gain(run.mesh, run.scale);
  for (int round = 0; round <= options.effort; ++round) {
    if (options.smoothing) run.report.moves += smoother.sweep(2);
    run.rule.mean_gain = mean_gain(run.mesh, run.scale);
    flip_all(run);
  }
  if (options.smoothing) run.report.moves += smoother.sweep(2);
  const char* reached = reached_stop(options.stop, target, 0, run.mesh.alive);
  run.report.stop = reached != nullptr ? reached : "limit";
  mesh = extract_mesh(std::move(run.mesh));
  run.report.vertices_out = mesh.points.size();
  run.report.tets_out = mesh.tets.size();
  return run.report;
}

}  // namespace palpate::simplify

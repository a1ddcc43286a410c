#include "core/simplify/surface.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/error.h"
#include "core/mesh/geometry.h"
#include "core/simplify/edge_removal.h"
#include "core/simplify/refined.h"
#include "core/simplify/smoothing.h"

namespace palpate::simplify {
namespace {

/// Greatest share of the tets that one stage leaves.
constexpr double kStage = 0.6;

struct Run {
  const SurfaceOptions& options;
  SizingField field;
  WorkingMesh mesh;
  Skin skin;
  SurfaceRunReport report;
  double volume = 0.0;
  ScoreScale scale;

  Run(TetMesh&& input, const SurfaceOptions& given)
      : options(given),
        field(given.sizing.keep.empty() ? SizingField() : SizingField(given.sizing, input)),
        mesh(build_working_mesh(std::move(input), field)),
        skin(mesh, given.max_surface_error) {
    report.vertices_in = mesh.points.size();
    report.tets_in = mesh.alive;
    report.boundary_faces_in = skin.size();
  }

  void aim_at(double tets) { scale = {1.0 / (6.0 * volume / std::max(1.0, tets)), 0.5}; }

  /// Boundary faces that go with so many tets.
  std::uint64_t faces_for(double tets) const {
    const double share = tets / static_cast<double>(report.tets_in);
    return static_cast<std::uint64_t>(
        std::ceil(static_cast<double>(report.boundary_faces_in) * std::pow(share, 2.0 / 3.0)));
  }

  /// Tets that go with the boundary as it is.
  double tets_for_faces() const {
    const double share = static_cast<double>(skin.size()) / static_cast<double>(report.boundary_faces_in);
    return static_cast<double>(report.tets_in) * std::pow(share, 1.5);
  }
};

constexpr double kLeastScores[] = {0.03, 0.003, 1e-9};

void coarsen_boundary(Run& run, std::uint64_t faces, std::uint64_t tets) {
  SurfaceCollapseOptions options;
  options.face_target = faces;
  options.tet_target = tets;
  for (const double least : kLeastScores) {
    if (run.skin.size() <= faces || run.mesh.alive <= tets) return;
    options.least_score = least;
    collapse_boundary_edges(run.mesh, run.skin, run.scale, run.field, options, run.report.surface);
  }
}

void coarsen_inside(Run& run, std::uint64_t tets) {
  CollapseOptions options;
  options.target = tets;
  for (const double least : kLeastScores) {
    if (run.mesh.alive <= tets) return;
    options.least_score = least;
    const CollapseReport now = collapse_edges(run.mesh, run.scale, run.field, options);
    run.report.inner.collapses += now.collapses;
    run.report.inner.rejected_link += now.rejected_link;
    run.report.inner.rejected_shape += now.rejected_shape;
  }
}

/// One stage: the boundary first, then the inside, then a sweep that evens out.
void run_stage(Run& run, double tets) {
  run.aim_at(tets);
  const auto target = static_cast<std::uint64_t>(tets);
  coarsen_boundary(run, run.faces_for(tets), target);
  coarsen_inside(run, target);
  Smoother(run.mesh, run.scale).sweep(2);
  if (run.options.boundary_smoothing) smooth_boundary(run.mesh, run.skin, run.scale, run.report.surface);
}

void coarsen_to(Run& run, std::uint64_t target) {
  const auto tets_in = static_cast<double>(run.report.tets_in);
  const double share = static_cast<double>(std::max<std::uint64_t>(1, target)) / tets_in;
  const int stages = std::max(1, static_cast<int>(std::ceil(std::log(share) / std::log(kStage))));
  for (int k = 1; k < stages; ++k) {
    run_stage(run, tets_in * std::pow(share, static_cast<double>(k) / stages));
  }
  run_stage(run, static_cast<double>(target));
}

/// Until the boundary gets no coarser; then the inside is brought in line with it.
void coarsen_to_limit(Run& run) {
  double tets = static_cast<double>(run.report.tets_in);
  std::size_t before = 0;
  do {
    before = run.skin.size();
    tets = std::max(1.0, kStage * tets);
    run.aim_at(tets);
    coarsen_boundary(run, run.faces_for(tets), 0);
    coarsen_inside(run, static_cast<std::uint64_t>(run.tets_for_faces()));
    Smoother(run.mesh, run.scale).sweep(2);
    if (run.options.boundary_smoothing) smooth_boundary(run.mesh, run.skin, run.scale, run.report.surface);
  } while (run.skin.size() < before);
  run.aim_at(run.tets_for_faces());
}

void improve(Run& run, std::uint64_t target) {
  FlipRule rule;
  rule.scale = run.scale;
  rule.most_tets = std::max<std::uint64_t>(target, run.mesh.alive);
  rule.fewest_tets = static_cast<std::uint64_t>(static_cast<double>(target) * 0.995) + 1;
  Smoother smoother(run.mesh, run.scale);
  Flipper flipper(run.mesh, rule);
  for (int round = 0; round <= run.options.effort; ++round) {
    smoother.sweep(2);
    if (run.options.boundary_smoothing) smooth_boundary(run.mesh, run.skin, run.scale, run.report.surface);
    const auto end = static_cast<Index>(run.mesh.tets.size());
    for (Index t = 0; t < end; ++t) {
      for (std::size_t e = 0; e < 6 && run.mesh.is_alive(t); ++e) {
        const Tet tet = run.mesh.tets[t];
        flipper.try_remove_edge(tet[static_cast<std::size_t>(kTetEdges[e][0])],
                                tet[static_cast<std::size_t>(kTetEdges[e][1])]);
      }
      for (std::size_t c = 0; c < 4 && run.mesh.is_alive(t); ++c) flipper.try_remove_face(t, c);
    }
  }
  smoother.sweep(2);
}

}  // namespace

void validate_options(const SurfaceOptions& options) {
  RefinedOptions common;
  common.stop = options.stop;
  common.effort = options.effort;
  validate_options(common);
  if (!(options.max_surface_error >= 0.0 && std::isfinite(options.max_surface_error))) {
    throw InputError("max_surface_error", 0, "a finite number that is not negative",
                     std::to_string(options.max_surface_error));
  }
}

SurfaceRunReport simplify_surface(TetMesh& mesh, const SurfaceOptions& options) {
  validate_options(options);
  const double volume = total_volume(mesh);
  const bool to_limit = !options.stop.tets && !options.stop.ratio;
  const std::uint64_t target = to_limit ? 0 : target_tet_count(options.stop, mesh.tets.size());
  Run run(std::move(mesh), options);
  run.volume = volume;
  if (to_limit) {
    coarsen_to_limit(run);
  } else {
    coarsen_to(run, target);
  }
  improve(run, to_limit ? run.mesh.alive : target);
  const char* reached = to_limit ? nullptr : reached_stop(options.stop, target, 0, run.mesh.alive);
  run.report.stop = reached != nullptr ? reached : "limit";
  run.report.boundary_faces_out = run.skin.size();
  mesh = extract_mesh(std::move(run.mesh));
  run.report.vertices_out = mesh.points.size();
  run.report.tets_out = mesh.tets.size();
  if (volume > 0.0) run.report.volume_drift_relative = std::fabs(total_volume(mesh) - volume) / volume;
  return run.report;
}

}  // namespace palpate::simplify

#include "core/simplify/surface/surface.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/mesh/geometry.h"
#include "core/simplify/refined/body_rate.h"
#include "core/simplify/refined/refined.h"
#include "core/simplify/surface/surface_coarsening.h"
#include "core/simplify/surface/surface_run.h"
#include "core/simplify/surface/surface_smoothing.h"
#include "core/simplify/tet_operations/smoothing.h"

namespace palpate::simplify {
namespace {

/// At the end, tets below the first score are repaired, below the second (for shapes: below the first) by
/// compound moves too; so many rounds, and one more for each effort; without any effort, a single one.
constexpr double kRepairScore = 0.16;
constexpr double kCompoundScore = 0.06;
constexpr int kLeastPolish = 2;

/// With more than the usual effort, tets at the skin below this score are at last worth a flip of their own.
constexpr double kWorstScore = 0.2;

/// Least share of the wanted count that flips may leave.
constexpr double kLeastShare = 0.998;
constexpr double kAimOfRefined = 1.004;

/// The boundary vertices, in the order of the mesh that extract_mesh would give.
std::vector<Index> boundary_vertices_in_order(const WorkingMesh& mesh) {
  std::vector<Index> vertices;
  for (Index v = 0; v < mesh.points.size(); ++v) {
    if (mesh.is_vertex_alive(v) && mesh.is_on_boundary(v)) vertices.push_back(v);
  }
  // Those that were added have no number of their own, and stay in the order of their slots.
  std::stable_sort(vertices.begin(), vertices.end(),
                   [&](Index a, Index b) { return mesh.vertex_origin[a] < mesh.vertex_origin[b]; });
  return vertices;
}

/// Hands the mesh to `refine`, one of refined.h's, and takes it back. The boundary vertices keep their order
/// in that, so the skin can be told their new numbers. `mesh` is scratch.
template <typename Refine>
RefinedReport refine_inside(SurfaceRun& run, TetMesh& mesh, const Refine& refine) {
  const std::vector<Index> before = boundary_vertices_in_order(run.mesh);
  std::vector<Vec3> places;
  places.reserve(before.size());
  for (const Index v : before) places.push_back(run.mesh.points[v]);
  std::vector<Index> new_number(run.mesh.points.size(), kNoIndex);
  mesh = extract_mesh(std::move(run.mesh));
  RefinedReport report = refine(mesh);
  run.mesh = build_working_mesh(std::move(mesh), run.field);
  const std::vector<Index> after = boundary_vertices_in_order(run.mesh);
  require(after.size() == before.size(), "surface: the boundary changed inside");
  for (std::size_t i = 0; i < after.size(); ++i) {
    require(run.mesh.points[after[i]] == places[i], "surface: the boundary moved inside");
    new_number[before[i]] = after[i];
  }
  run.boundary.renumber(new_number, run.mesh.points.size());
  return report;
}

/// The inside of a skin that stays: to the count or, where it is out of reach, to the fewest tets that two
/// searches, or a plain run, leave.
RefinedReport refine_to_fewest(TetMesh& mesh, const RefinedOptions& options) {
  RefinedOptions own = options;
  own.abandon_beyond = kShort;
  TetMesh body = mesh;
  RefinedReport report = simplify_refined(body, own);
  if (report.stop == "limit") {
    own = options;
    own.stop.tets = 1;
    body = mesh;
    report = simplify_refined(body, own);
    RefinedReport searched = simplify_to_limit(mesh, options);
    if (searched.stop == "limit") searched = simplify_to_limit(mesh, options);  // it goes a few tets further
    if (searched.stop != "limit" || mesh.tets.size() <= body.tets.size()) return searched;
  }
  mesh = std::move(body);
  return report;
}

/// As far as it goes, but no farther than the target. All on the way but its end is the same for each target.
RefinedReport go_farthest(SurfaceRun& run, TetMesh& mesh, const RefinedOptions& inside,
                          std::uint64_t target) {
  RefinedReport report;
  std::size_t faces = 0;
  do {
    if (run.mesh.alive <= target) break;
    report = refine_inside(run, mesh, [&](TetMesh& body) { return refine_to_fewest(body, inside); });
    faces = run.boundary.size();
    press_on(run, target, 1.0);
  } while (run.boundary.size() < faces);
  return report;
}

/// How far flips may take the count.
FlipRule window_of(const SurfaceRun& run, std::uint64_t target) {
  FlipRule rule;
  rule.fewest_tets = static_cast<std::uint64_t>(kLeastShare * static_cast<double>(target)) + 1;
  rule.most_tets = std::max<std::uint64_t>(target, run.mesh.alive);
  return rule;
}

/// Flips in the skin for the worst tets alone: what is left of these is often a single one that lies flat on
/// it.
void flip_for_worst(SurfaceRun& run, const FlipRule& rule) {
  if (!run.options.boundary_flips) return;
  BoundaryFlipper flipper(run.mesh, run.boundary, run.scores, FlipAim::kWorst);
  flipper.set_may_fold(false);
  flipper.set_range(rule.fewest_tets, rule.most_tets);
  run.report.surface.flips += flipper.pass(run.flips_below(kWorstScore));
}

/// Last flips and moves in the skin, now that the inside is good, moves inside and repairs.
void polish(SurfaceRun& run, std::uint64_t target) {
  run.aim_at(static_cast<double>(target));
  const FlipRule rule = window_of(run, target);
  BoundaryFlipper flipper = flipper_of(run);
  flipper.set_range(rule.fewest_tets, rule.most_tets);
  Smoother smoother(run.mesh, run.scores);
  Repairer repairer(run.mesh, run.scores, rule, run.tools());
  const double compound = run.is_for_shape() ? kRepairScore : kCompoundScore;
  const int rounds = run.is_quick() ? 1 : kLeastPolish + run.options.effort;
  for (int round = 0; round < rounds; ++round) {
    flip_boundary(run, flipper);
    if (run.is_for_shape() && run.options.effort > 1 && round + 1 == rounds) flip_for_worst(run, rule);
    move_boundary(run);
    if (run.is_for_shape()) smoother.sweep(1);
    repairer.round(run.repairs_below(kRepairScore), run.repairs_below(compound), 2);
  }
}

}  // namespace

void validate_options(const SurfaceOptions& options) {
  RefinedOptions common;
  common.stop = options.stop;
  if (!common.stop.fusions && !common.stop.ratio && !common.stop.tets) common.stop.tets = 1;  // to the limit
  common.effort = options.effort;
  validate_options(common);
  if (!(options.max_surface_error >= 0.0 && std::isfinite(options.max_surface_error))) {
    throw InputError("max_surface_error", 0, "a finite number that is not negative",
                     std::to_string(options.max_surface_error));
  }
  if (!(options.boundary_size > 0.0 && std::isfinite(options.boundary_size))) {
    throw InputError("boundary_size", 0, "a number above 0", std::to_string(options.boundary_size));
  }
  if (!(options.feature_deg >= 0.0 && options.feature_deg < 180.0)) {
    throw InputError("feature_deg", 0, "degrees from 0 (none) to less than 180",
                     std::to_string(options.feature_deg));
  }
}

namespace {

/// Lets go of the vertices that hold the longest stable step down, those of a skin that was coarsened too:
/// all of the bound is there for that.
void lengthen_step(SurfaceRun& run, std::uint64_t target) {
  run.aim_at(static_cast<double>(target));
  const bool moves_skin = run.takes_boundary() && run.options.boundary_smoothing;
  if (moves_skin) run.boundary.raise_bound(run.mesh, run.options.max_surface_error);
  StepSkinMoves skin(run.mesh, run.boundary, run.report.surface);
  StepLengthener lengthener(run.mesh, run.scores, window_of(run, target), moves_skin ? &skin : nullptr);
  lengthener.run(kStepRounds);
}

/// simplify_surface with tets scored for one thing, and a longer step made in the end if the options want it.
SurfaceRunReport simplify_scored(TetMesh& mesh, const SurfaceOptions& options, Objective scored, Way way) {
  const bool to_limit = !options.stop.tets && !options.stop.ratio;
  std::uint64_t target = to_limit ? 0 : target_tet_count(options.stop, mesh.tets.size());
  SurfaceRun run(std::move(mesh), options, scored);
  if (to_limit) {
    coarsen_to_limit(run);
    target = std::min(run.report.tets_in, static_cast<std::uint64_t>(run.tets_for_faces()));
  } else {
    coarsen_to(run, way == Way::kFarthest ? 1.0 : static_cast<double>(target), target, way);
  }
  RefinedOptions inside;
  target = std::max<std::uint64_t>(1, target);
  // Refined may end 0.5% below; some collapses from a little above get closer.
  const double aim = run.takes_boundary() && way == Way::kStraight ? kAimOfRefined : 1.0;
  inside.stop.tets = static_cast<std::uint64_t>(aim * static_cast<double>(target));
  inside.objective = run.scored;
  inside.tools = run.tools();
  inside.effort = options.effort;
  inside.sizing = options.sizing;
  inside.sizing.reach = run.field.reach();
  const std::uint64_t wanted = target;
  RefinedReport refined;
  if (way == Way::kFarthest) {
    refined = go_farthest(run, mesh, inside, target);
    target = std::max<std::uint64_t>(target, run.mesh.alive);
  } else {
    refined = refine_inside(run, mesh, [&](TetMesh& body) { return simplify_refined(body, inside); });
    press_on(run, target, static_cast<double>(target));
    if (run.evens_boundary()) make_up_for_last(run, window_of(run, target).fewest_tets, target);
  }
  if (run.takes_boundary()) polish(run, target);
  if (options.objective == Objective::kStableStep) lengthen_step(run, target);
  run.report.boundary_faces_out = run.boundary.size();
  run.report.feature_edges_out = run.boundary.lines().size();
  mesh = extract_mesh(std::move(run.mesh));
  SurfaceRunReport report = std::move(run.report);
  report.inner.collapses += refined.collapses.collapses;
  report.inner.rejected_link = refined.collapses.rejected_link;
  report.inner.rejected_shape = refined.collapses.rejected_shape;
  report.stop = to_limit ? "limit" : stop_or_limit(options.stop, wanted, mesh.tets.size());
  report.vertices_out = mesh.points.size();
  report.tets_out = mesh.tets.size();
  if (run.volume > 0.0) {
    report.volume_drift_relative = std::fabs(total_volume(mesh) - run.volume) / run.volume;
  }
  return report;
}

SurfaceRunReport simplify_by(TetMesh& mesh, const SurfaceOptions& options, Way way) {
  validate_options(options);
  if (options.objective != Objective::kStableStep)
    return simplify_scored(mesh, options, options.objective, way);
  // Where the skin decides, neither kind of scores is always ahead.
  TetMesh other = mesh;
  SurfaceRunReport report = simplify_scored(mesh, options, Objective::kShape, way);
  SurfaceRunReport other_report = simplify_scored(other, options, Objective::kQuality, way);
  const bool is_short = report.stop == "limit";
  const bool is_other_short = other_report.stop == "limit";
  const bool is_better = is_short == is_other_short ? swings_slower(other, mesh) : is_short;
  if (!is_better) return report;
  mesh = std::move(other);
  return other_report;
}

}  // namespace

SurfaceRunReport simplify_surface(TetMesh& mesh, const SurfaceOptions& options) {
  return simplify_by(mesh, options, Way::kStraight);
}

SurfaceRunReport simplify_surface_to_limit(TetMesh& mesh, const SurfaceOptions& options) {
  return simplify_by(mesh, options,
                     options.stop.tets || options.stop.ratio ? Way::kFarthest : Way::kStraight);
}

}  // namespace palpate::simplify

#include "core/simplify/surface/surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "core/base/error.h"
#include "core/mesh/geometry.h"
#include "core/simplify/refined/refined.h"
#include "core/simplify/refined/vertex_rate.h"
#include "core/simplify/surface/surface_flip.h"
#include "core/simplify/surface/surface_smoothing.h"
#include "core/simplify/tet_operations/smoothing.h"

namespace palpate::simplify {
namespace {

/// Greatest share of the tets that one stage leaves.
constexpr double kStage = 0.6;

/// At the end, tets below the first score are repaired, below the second by compound moves too; so many
/// rounds, and one more for each effort.
constexpr double kRepairScore = 0.16;
constexpr double kCompoundScore = 0.06;
constexpr int kLeastPolish = 2;

/// Least share of the wanted count that flips may leave.
constexpr double kLeastShare = 0.998;
constexpr double kAimOfRefined = 1.004;

/// Where the stages end, over the target: simplify_refined does the rest.
constexpr double kLeftToRefined = 1.5;

/// Shares of the bound that are used up one after another.
constexpr std::array kErrorLevels{0.125, 0.25, 0.5, 1.0};

/// Below this score (q = 0.67) a tet at the boundary is worth a flip.
constexpr double kPoorScore = 0.3;

// In a mesh of good tets with mean edge h, a tet has about 0.1 h^3 (a regular one 0.118), a boundary face
// about 0.41 h^2 (an equilateral one 0.433).
constexpr double kTetShare = 0.1;
constexpr double kFaceShare = 0.41;

struct Run {
  const SurfaceOptions& options;
  Objective scored;  ///< kShape or kQuality
  SizingField field;
  double volume = 0.0;
  double room = 0.0;  ///< the volume, where the field wants less over its relative size cubed
  WorkingMesh mesh;
  std::size_t level = 0;  ///< of kErrorLevels: how much of the bound is in use
  GuardedBoundary boundary;
  SurfaceRunReport report;
  double area = 0.0;  ///< graded_area of the input's skin
  ScoreRule scores;

  Run(TetMesh&& input, const SurfaceOptions& given, Objective scored_for)
      : options(given),
        scored(scored_for),
        field(given.sizing, input),
        volume(total_volume(input)),
        room(field.is_empty() ? volume : graded_volume(input, field)),
        mesh(build_working_mesh(std::move(input), field)),
        level(given.sparing ? 0 : kErrorLevels.size() - 1),
        boundary(mesh, kErrorLevels[level] * given.max_surface_error, given.feature_deg),
        scores(scale_of(1.0), field) {
    report.vertices_in = mesh.points.size();
    report.tets_in = mesh.alive;
    report.boundary_faces_in = boundary.size();
    report.feature_edges_in = boundary.lines().size();
    report.feature_corners = boundary.lines().corners();
    report.input_contact = boundary.find_contact(mesh);
    for (Index f = 0; f < boundary.slots(); ++f) {
      const Triangle& t = boundary.face(f);
      area += graded_area(t);
    }
  }

  /// Area of a face, over the square of the relative size wanted at its middle.
  double graded_area(const Triangle& t) const {
    const Vec3& p = mesh.points[t[0]];
    const double flat = 0.5 * length(cross(mesh.points[t[1]] - p, mesh.points[t[2]] - p));
    if (field.is_empty()) return flat;
    const double size = field.relative_size((1.0 / 3.0) * (p + mesh.points[t[1]] + mesh.points[t[2]]));
    return flat / (size * size);
  }

  ScoreScale scale_of(double ideal_volume) const {
    return scale_of_ideal_volume(ideal_volume, form_of(scored));
  }

  /// By solid angles repairs may leave a tet worse than what they found.
  RepairTools tools() const { return {.never_worse = scored == Objective::kShape}; }

  /// Thresholds of scores by solid angles, in the scale's own.
  double flips_below(double score) const { return scores.far().flip_share * score; }
  double repairs_below(double score) const { return scores.far().repair_share * score; }

  /// Whether skin and inside are evened out for the best shapes. That leads away from sizes that are wanted,
  /// and from what makes a step longer.
  bool is_for_shape() const { return options.objective == Objective::kShape && field.is_empty(); }

  /// Whether the skin is worked on: where it was coarsened, or where the bound is there to be spent.
  bool takes_boundary() const { return report.surface.collapses > 0 || (is_for_shape() && !options.sparing); }

  void aim_at(double tets) {
    scores = ScoreRule(scale_of(room / std::max(1.0, tets)), field);
    std::fill(mesh.score.begin(), mesh.score.end(), WorkingMesh::kNoScore);  // they were for another aim
  }

  /// Boundary faces whose edges are `boundary_size` times as long as those of so many tets inside.
  std::uint64_t faces_for(double tets) const {
    const double edge = options.boundary_size * std::cbrt(room / (kTetShare * tets));
    return static_cast<std::uint64_t>(std::ceil(area / (kFaceShare * edge * edge)));
  }

  /// Where sizes differ, what is refused in one place must not be made up for in another: no edge that is
  /// longer than wanted is collapsed while there is a plan. Relative to the wanted size.
  double longest_for(double tets, double boundary_size) const {
    if (field.is_empty()) return std::numeric_limits<double>::infinity();
    return boundary_size * std::cbrt(room / (kTetShare * std::max(1.0, tets)));
  }

  /// The other way round: tets that go with the boundary as it is.
  double tets_for_faces() const {
    const double edge = std::sqrt(area / (kFaceShare * static_cast<double>(boundary.size())));
    const double inner = edge / options.boundary_size;
    return room / (kTetShare * inner * inner * inner);
  }
};

/// Least scores that collapses leave, the better ones first. The last one takes all that is not flat.
constexpr std::array kLeastScores{0.03, 0.003, 1e-9};

/// An edge of the skin is a needle's below this share of those of as many equilateral faces as are wanted.
constexpr double kNeedle = 0.25;

/// Collapses the needles of a skin, wherever the tets are worth more after that, in sum. Those at a needle
/// are too bad for a collapse to be held to a score: while other edges suffice needles would stay for good.
void cure_needles(Run& run, std::uint64_t faces, std::uint64_t tets) {
  SurfaceCollapseOptions options;
  options.least_score = kLeastScores.front();
  options.is_cure = true;
  const std::size_t wanted = faces > 0 ? faces : run.boundary.size();
  options.longest = kNeedle * std::sqrt(run.area / (kFaceShare * static_cast<double>(wanted)));
  options.tet_target = tets;
  collapse_boundary_edges(run.mesh, run.boundary, run.scores, options, run.report.surface);
}

/// Takes what a small part of the bound permits first, and more of it only if that is not enough; poor tets
/// only where all of the bound is not enough.
void coarsen_boundary(Run& run, std::uint64_t faces, std::uint64_t tets,
                      double longest = std::numeric_limits<double>::infinity()) {
  SurfaceCollapseOptions options;
  options.longest = longest;
  options.face_target = faces;
  options.tet_target = tets;
  const auto is_enough = [&] { return run.boundary.size() <= faces || run.mesh.alive <= tets; };
  for (const double least : kLeastScores) {
    options.least_score = least;
    for (;; ++run.level) {
      if (is_enough()) return;
      run.boundary.raise_bound(run.mesh, kErrorLevels[run.level] * run.options.max_surface_error);
      if (least == kLeastScores.front()) cure_needles(run, faces, tets);
      collapse_boundary_edges(run.mesh, run.boundary, run.scores, options, run.report.surface);
      if (run.level + 1 == kErrorLevels.size()) break;
    }
  }
}

void coarsen_inside(Run& run, std::uint64_t tets, double longest = std::numeric_limits<double>::infinity()) {
  CollapseOptions options;
  options.longest = longest;
  options.target = tets;
  for (const double least : kLeastScores) {
    if (run.mesh.alive <= tets) return;
    options.least_score = least;
    run.report.inner.collapses += collapse_edges(run.mesh, run.scores, options).collapses;
  }
}

BoundaryFlipper flipper_of(Run& run) {
  return {run.mesh, run.boundary, run.scores, run.is_for_shape() ? FlipAim::kSum : FlipAim::kWorst};
}

void flip_boundary(Run& run, BoundaryFlipper& flipper) {
  if (!run.options.boundary_flips) return;
  const double below =
      run.is_for_shape() ? std::numeric_limits<double>::infinity() : run.flips_below(kPoorScore);
  run.report.surface.flips += flipper.pass(below);
}

/// Moves in the skin: for the best shapes, or to mend the worst.
void move_boundary(Run& run) {
  if (!run.options.boundary_smoothing) return;
  if (run.is_for_shape())
    smooth_boundary(run.mesh, run.boundary, run.scores, run.volume, run.report.surface);
  else
    mend_boundary(run.mesh, run.boundary, run.scores, run.report.surface);
}

/// Flips and moves in the skin, where it was coarsened, and moves inside.
void even_out(Run& run) {
  Smoother smoother(run.mesh, run.scores);
  smoother.sweep(2);
  if (!run.takes_boundary()) return;
  BoundaryFlipper flipper = flipper_of(run);
  flip_boundary(run, flipper);
  move_boundary(run);
}

/// Down to a little more than the target: the rest is left to simplify_refined.
void coarsen_to(Run& run, double target) {
  if (run.faces_for(target) >= run.boundary.size()) return;  // the skin is coarse enough: all is refined's
  const auto tets_in = static_cast<double>(run.report.tets_in);
  const double share = std::min(1.0, kLeftToRefined * std::max(1.0, target) / tets_in);
  const int stages = std::max(1, static_cast<int>(std::ceil(std::log(share) / std::log(kStage))));
  for (int k = 1; k <= stages; ++k) {
    const double tets = tets_in * std::pow(share, static_cast<double>(k) / stages);
    run.aim_at(tets);
    const double faces_of = k < stages ? tets : target;
    coarsen_boundary(run, run.faces_for(faces_of), static_cast<std::uint64_t>(target),
                     run.longest_for(faces_of, run.options.boundary_size));
    coarsen_inside(run, static_cast<std::uint64_t>(tets), run.longest_for(tets, 1.0));
    even_out(run);
  }
}

/// Until the boundary gets no coarser.
void coarsen_to_limit(Run& run) {
  double tets = static_cast<double>(run.report.tets_in);
  std::size_t before = 0;
  do {
    before = run.boundary.size();
    tets = std::max(1.0, kStage * tets);
    run.aim_at(tets);
    coarsen_boundary(run, run.faces_for(tets), 0);
    coarsen_inside(run, static_cast<std::uint64_t>(kLeftToRefined * run.tets_for_faces()));
    even_out(run);
  } while (run.boundary.size() < before || run.faces_for(tets) > run.boundary.size());
}

/// The boundary vertices, in the order of the mesh that extract_mesh would give.
std::vector<Index> boundary_vertices_in_order(const WorkingMesh& mesh) {
  std::vector<Index> vertices;
  for (Index v = 0; v < mesh.points.size(); ++v) {
    if (mesh.is_vertex_alive(v) && mesh.is_on_boundary(v)) vertices.push_back(v);
  }
  std::sort(vertices.begin(), vertices.end(),
            [&](Index a, Index b) { return mesh.vertex_origin[a] < mesh.vertex_origin[b]; });
  return vertices;
}

/// Hands the mesh to simplify_refined and takes it back. The boundary vertices keep their order in that, so
/// the skin can be told their new numbers. `mesh` is scratch.
RefinedReport refine_inside(Run& run, TetMesh& mesh, const RefinedOptions& options) {
  const std::vector<Index> before = boundary_vertices_in_order(run.mesh);
  std::vector<Vec3> places;
  places.reserve(before.size());
  for (const Index v : before) places.push_back(run.mesh.points[v]);
  std::vector<Index> new_number(run.mesh.points.size(), kNoIndex);
  mesh = extract_mesh(std::move(run.mesh));
  RefinedReport report = simplify_refined(mesh, options);
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

/// Down to the count itself. If the inside does not get there, the skin gives way further than planned.
void press_on(Run& run, std::uint64_t target) {
  if (run.mesh.alive <= target) return;
  run.aim_at(static_cast<double>(target));
  coarsen_inside(run, target);
  coarsen_boundary(run, 0, target);
  coarsen_inside(run, target);
}

/// How far flips may take the count.
FlipRule window_of(const Run& run, std::uint64_t target) {
  FlipRule rule;
  rule.fewest_tets = static_cast<std::uint64_t>(kLeastShare * static_cast<double>(target)) + 1;
  rule.most_tets = std::max<std::uint64_t>(target, run.mesh.alive);
  return rule;
}

/// Last flips and moves in the skin, now that the inside is good, moves inside and repairs.
void polish(Run& run, std::uint64_t target) {
  run.aim_at(static_cast<double>(target));
  const FlipRule rule = window_of(run, target);
  BoundaryFlipper flipper = flipper_of(run);
  flipper.set_range(rule.fewest_tets, rule.most_tets);
  Smoother smoother(run.mesh, run.scores);
  Repairer repairer(run.mesh, run.scores, rule, run.tools());
  for (int round = 0; round < kLeastPolish + run.options.effort; ++round) {
    flip_boundary(run, flipper);
    move_boundary(run);
    if (run.is_for_shape()) smoother.sweep(1);
    repairer.round(run.repairs_below(kRepairScore), run.repairs_below(kCompoundScore), 2);
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

/// simplify_surface with tets scored for one thing, and a longer step made in the end if the options want it.
SurfaceRunReport simplify_scored(TetMesh& mesh, const SurfaceOptions& options, Objective scored) {
  const bool to_limit = !options.stop.tets && !options.stop.ratio;
  std::uint64_t target = to_limit ? 0 : target_tet_count(options.stop, mesh.tets.size());
  Run run(std::move(mesh), options, scored);
  if (to_limit) {
    coarsen_to_limit(run);
    target = std::min(run.report.tets_in, static_cast<std::uint64_t>(run.tets_for_faces()));
  } else {
    coarsen_to(run, static_cast<double>(target));
  }
  RefinedOptions inside;
  target = std::max<std::uint64_t>(1, target);
  // Refined may end 0.5% below; some collapses from a little above get closer.
  const double aim = run.takes_boundary() ? kAimOfRefined : 1.0;
  inside.stop.tets = static_cast<std::uint64_t>(aim * static_cast<double>(target));
  inside.objective = run.scored;
  inside.tools = run.tools();
  inside.effort = options.effort;
  inside.sizing = options.sizing;
  inside.sizing.reach = run.field.reach();
  const RefinedReport refined = refine_inside(run, mesh, inside);
  press_on(run, target);
  if (run.takes_boundary()) polish(run, target);
  if (options.objective == Objective::kStableStep) {
    run.aim_at(static_cast<double>(target));
    StepLengthener(run.mesh, run.scores, window_of(run, target)).run(kStepRounds);
  }
  run.report.boundary_faces_out = run.boundary.size();
  run.report.feature_edges_out = run.boundary.lines().size();
  mesh = extract_mesh(std::move(run.mesh));
  SurfaceRunReport report = std::move(run.report);
  report.inner.collapses += refined.collapses.collapses;
  report.inner.rejected_link = refined.collapses.rejected_link;
  report.inner.rejected_shape = refined.collapses.rejected_shape;
  report.stop = to_limit ? "limit" : stop_or_limit(options.stop, target, mesh.tets.size());
  report.vertices_out = mesh.points.size();
  report.tets_out = mesh.tets.size();
  if (run.volume > 0.0) {
    report.volume_drift_relative = std::fabs(total_volume(mesh) - run.volume) / run.volume;
  }
  return report;
}

}  // namespace

SurfaceRunReport simplify_surface(TetMesh& mesh, const SurfaceOptions& options) {
  validate_options(options);
  if (options.objective != Objective::kStableStep) return simplify_scored(mesh, options, options.objective);
  // Where the skin decides, neither kind of scores is always ahead.
  TetMesh other = mesh;
  SurfaceRunReport report = simplify_scored(mesh, options, Objective::kShape);
  SurfaceRunReport other_report = simplify_scored(other, options, Objective::kQuality);
  const bool is_short = report.stop == "limit";
  const bool is_other_short = other_report.stop == "limit";
  const bool is_better = is_short == is_other_short ? greatest_rate(other) < greatest_rate(mesh) : is_short;
  if (!is_better) return report;
  mesh = std::move(other);
  return other_report;
}

}  // namespace palpate::simplify

#include "core/simplify/surface/surface_coarsening.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/simplify/surface/surface_collapse.h"
#include "core/simplify/surface/surface_smoothing.h"
#include "core/simplify/surface/surface_split.h"
#include "core/simplify/tet_operations/edge_collapse.h"
#include "core/simplify/tet_operations/smoothing.h"

namespace palpate::simplify {
namespace {

/// Greatest share of the tets that one stage leaves.
constexpr double kStage = 0.6;

/// Where the stages end, over the target: simplify_refined does the rest.
constexpr double kLeftToRefined = 1.5;

/// Below this score (q = 0.67) a tet at the boundary is worth a flip.
constexpr double kPoorScore = 0.3;

/// Least scores that collapses leave, the better ones first. The last one takes all that is not flat.
constexpr std::array kLeastScores{0.03, 0.003, 1e-9};

/// Edges of the skin over those of as many equilateral faces as are wanted: below the first they are a
/// needle's; below the second they are short, beyond the third long.
constexpr double kNeedle = 0.25;
constexpr double kShortEdge = 0.7;
constexpr double kLongEdge = 1.3;
constexpr double kLeftForInside = 0.07;  ///< of the target, beside it: cures of short edges end there
constexpr double kLeftForShort = 0.95;   ///< of the faces wanted: splits of long edges end there

/// Collapses edges of the skin below a share of the wanted length, wherever the tets are worth more after
/// that, in sum. Those at a needle are too bad for a collapse to be held to a score: while other edges
/// suffice needles would stay for good.
void cure_short_edges(SurfaceRun& run, double share, std::uint64_t faces, std::uint64_t tets) {
  SurfaceCollapseOptions options;
  options.least_score = kLeastScores.front();
  options.is_cure = true;
  options.longest = share * run.edge_of_skin(faces > 0 ? faces : run.boundary.size());
  options.tet_target = tets;
  collapse_boundary_edges(run.mesh, run.boundary, run.scores, options, run.report.surface);
}

/// Takes what a small part of the bound permits first, and more of it only if that is not enough; poor tets
/// only where all of the bound is not enough.
void coarsen_boundary(SurfaceRun& run, std::uint64_t faces, std::uint64_t tets,
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
      if (least == kLeastScores.front()) cure_short_edges(run, kNeedle, faces, tets);
      collapse_boundary_edges(run.mesh, run.boundary, run.scores, options, run.report.surface);
      if (run.level + 1 == kErrorLevels.size()) break;
    }
  }
}

void coarsen_inside(SurfaceRun& run, std::uint64_t tets,
                    double longest = std::numeric_limits<double>::infinity()) {
  CollapseOptions options;
  options.longest = longest;
  options.target = tets;
  for (const double least : kLeastScores) {
    if (run.mesh.alive <= tets) return;
    options.least_scores = {&least, 1};
    run.report.inner.collapses += collapse_edges(run.mesh, run.scores, options).collapses;
  }
}

/// Moves inside.
void even_inside(SurfaceRun& run) {
  Smoother smoother(run.mesh, run.scores);
  smoother.sweep(run.is_quick() ? 1 : 2);
}

/// Flips and moves in the skin, where it was coarsened.
void even_skin(SurfaceRun& run) {
  if (!run.takes_boundary()) return;
  BoundaryFlipper flipper = flipper_of(run);
  flip_boundary(run, flipper);
  move_boundary(run);
}

void even_out(SurfaceRun& run) {
  even_inside(run);
  even_skin(run);
}

/// Splits edges of the skin that are too long for so many faces, as long as there are fewer.
void split_long_edges(SurfaceRun& run, std::uint64_t faces) {
  SurfaceSplitOptions options;
  options.shortest = kLongEdge * run.edge_of_skin(faces);
  options.least_score = kLeastScores.front();
  options.face_target = static_cast<std::uint64_t>(std::ceil(kLeftForShort * static_cast<double>(faces)));
  run.report.surface.splits += split_boundary_edges(run.mesh, run.boundary, run.scores, options);
}

/// The lengths of a skin's edges, of which collapses leave many too short and many too long: short ones go,
/// and long ones are split in exchange, once for each effort and at least once. Each face more takes some
/// three tets: `tets` have to be left for the inside to follow.
void even_edges(SurfaceRun& run, std::uint64_t faces, std::uint64_t tets) {
  for (int round = 0; round < std::max(1, run.options.effort); ++round) {
    cure_short_edges(run, kShortEdge, faces, tets);
    split_long_edges(run, faces);
    even_out(run);
  }
  if (run.is_quick()) return;
  cure_short_edges(run, kShortEdge, faces, tets);
  even_out(run);
}

}  // namespace

BoundaryFlipper flipper_of(SurfaceRun& run) {
  return {run.mesh, run.boundary, run.scores, run.is_for_shape() ? FlipAim::kSum : FlipAim::kWorst};
}

void flip_boundary(SurfaceRun& run, BoundaryFlipper& flipper) {
  if (!run.options.boundary_flips) return;
  const double below =
      run.is_for_shape() ? std::numeric_limits<double>::infinity() : run.flips_below(kPoorScore);
  run.report.surface.flips += flipper.pass(below);
}

void move_boundary(SurfaceRun& run) {
  if (!run.options.boundary_smoothing) return;
  if (run.is_for_shape())
    smooth_boundary(run.mesh, run.boundary, run.scores, run.volume, run.report.surface,
                    run.is_quick() ? kWorthAProofInHaste : kWorthAProof);
  else
    mend_boundary(run.mesh, run.boundary, run.scores, run.report.surface);
}

void coarsen_to(SurfaceRun& run, double target, std::uint64_t enough, Way way) {
  if (run.faces_for(target) >= run.boundary.size()) return;  // the skin is coarse enough: all is refined's
  const auto tets_in = static_cast<double>(run.report.tets_in);
  const double share = std::min(1.0, kLeftToRefined * std::max(1.0, target) / tets_in);
  const int stages = std::max(1, static_cast<int>(std::ceil(std::log(share) / std::log(kStage))));
  const auto evens_edges = [&] {
    return run.spends_bound() || (run.evens_boundary() && way == Way::kStraight);
  };
  for (int k = 1; k <= stages; ++k) {
    const double tets = tets_in * std::pow(share, static_cast<double>(k) / stages);
    run.aim_at(tets);
    const double faces_of = k < stages ? tets : target;
    coarsen_boundary(run, run.faces_for(faces_of), enough,
                     run.longest_for(faces_of, run.options.boundary_size));
    coarsen_inside(run, std::max(static_cast<std::uint64_t>(tets), enough), run.longest_for(tets, 1.0));
    even_inside(run);
    if (!run.is_quick() || (k == stages && !evens_edges())) even_skin(run);
  }
  if (evens_edges())
    even_edges(run, run.faces_for(target), enough + static_cast<std::uint64_t>(kLeftForInside * target));
}

void coarsen_to_limit(SurfaceRun& run) {
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

void press_on(SurfaceRun& run, std::uint64_t target, double aim) {
  if (run.mesh.alive <= target) return;
  run.aim_at(aim);
  coarsen_inside(run, target);
  coarsen_boundary(run, 0, target);
  coarsen_inside(run, target);
}

void make_up_for_last(SurfaceRun& run, std::uint64_t fewest, std::uint64_t target) {
  SurfaceSplitOptions options;
  options.least_score = kLeastScores.front();
  options.tet_target = fewest;
  options.most_tets = target;
  run.report.surface.splits += split_boundary_edges(run.mesh, run.boundary, run.scores, options);
}

}  // namespace palpate::simplify

// palpate.refined: collapse, and repair in between, up to a remesher's quality, with the boundary untouched.
#pragma once

#include <cstdint>
#include <limits>
#include <string>

#include "core/mesh/tet_mesh.h"
#include "core/simplify/fusion/fusion_options.h"
#include "core/simplify/refined/repair.h"
#include "core/simplify/refined/stable_step.h"
#include "core/simplify/sizing/sizing.h"
#include "core/simplify/tet_operations/edge_collapse.h"

namespace palpate::simplify {

/// The highest effort.
inline constexpr int kMostEffort = 5;

/// What palpate.refined scores tets by for an objective.
constexpr ScoreForm form_of(Objective objective) {
  return objective == Objective::kQuality ? ScoreForm::kSolidAngle : ScoreForm::kMeanRatio;
}

/// How far the mesh is coarsened, and by which means.
struct RefinedOptions {
  StopRule stop;  ///< tets or ratio; there are no fusions, and no limit: the count decides the wanted size
  Objective objective = Objective::kShape;
  int effort = 1;  ///< 0 .. kMostEffort: more passes and higher thresholds, better and slower
  CollapsePlacement collapse_placement = CollapsePlacement::kFirst;
  bool interleave = true;  ///< smooth and flip on the way down; else collapse in one go
  bool repair = true;      ///< the worst tets one by one, at the end
  RepairTools tools;       ///< smoothing, edge and face removal hold for all of the run
  SizingOptions sizing;
  /// Where collapses leave more than so many times the wanted count, the run ends, with stop "limit" and a
  /// mesh that is valid and not finished: for a caller who has no use for it.
  double abandon_beyond = std::numeric_limits<double>::infinity();
};

/// Where collapses end so far above the wanted count it is out of reach: twice what repairs have ever made up
/// for.
inline constexpr double kShort = 1.06;

/// What was done.
struct RefinedReport {
  std::uint64_t vertices_in = 0;
  std::uint64_t vertices_out = 0;
  std::uint64_t tets_in = 0;
  std::uint64_t tets_out = 0;
  CollapseReport collapses;
  RepairCounts counts;
  std::string stop;  ///< "tets", "ratio", or "limit" when nothing more could be collapsed
};

/// Throws: InputError for a stop other than tets or ratio, a ratio outside [0, 1), an effort out of range.
void validate_options(const RefinedOptions& options);

/// Simplifies `mesh` in place.
///
///   while there are more tets than wanted: collapse the shortest inner edges by a share of the tets, smooth
///   every free vertex once, flip where it helps; at the wanted count smooth and flip again, then repair the
///   worst tets one by one.
///
/// Scores are those of ScoreScale in the objective's form, with the ideal volume of the wanted count. Every
/// operation leaves every tet positive, exactly; boundary vertices and faces stay as they are, to the bit;
/// kept tets too. The same input gives the same bytes. A mesh that has no more tets than wanted is left as it
/// is.
///
/// Ends at most 0.5% below the wanted count (or one collapse, about 8 tets, if that is more); a run that can
/// collapse nothing more ends above it, with stop "limit".
/// Time: about linear. Memory: about 70 bytes a tet of the input at most, the input among them.
/// Requires: positive tets. Throws: InputError for impossible options or a non-manifold face.
/// Source:  docs/refined.md.
RefinedReport simplify_refined(TetMesh& mesh, const RefinedOptions& options);

/// For a count that simplify_refined has not reached: down to twice the skin's faces, then from there to the
/// count and, if that is not reached either, by bisection, to 1% and less, to the fewest tets that a run from
/// there reaches. In that search the count plays no part, so all counts below the border end alike. The
/// report's operations are those of the best run. What to abandon it decides itself.
///
/// Time: a run, and some twenty on a mesh of twice the skin's faces. Requires and throws: as
/// simplify_refined.
RefinedReport simplify_to_limit(TetMesh& mesh, const RefinedOptions& options);

}  // namespace palpate::simplify

// What a run of simplify_surface works on, and the sizes that it aims at.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "core/mesh/geometry.h"
#include "core/simplify/quality/quality.h"
#include "core/simplify/refined/refined.h"
#include "core/simplify/sizing/sizing.h"
#include "core/simplify/skin_guard/guarded_boundary.h"
#include "core/simplify/surface/surface_options.h"
#include "core/simplify/tet_operations/working_mesh.h"

namespace palpate::simplify {

/// Shares of the bound that are used up one after another.
inline constexpr std::array kErrorLevels{0.125, 0.25, 0.5, 1.0};

/// In a mesh of good tets with mean edge h: the volume of a tet over h^3 (of a regular one 0.118), the area
/// of a boundary face over h^2 (of an equilateral one 0.433).
inline constexpr double kTetShare = 0.1;
inline constexpr double kFaceShare = 0.41;  ///< see kTetShare

/// Mesh, skin, bound and scores of a run of simplify_surface.
struct SurfaceRun {
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

  SurfaceRun(TetMesh&& input, const SurfaceOptions& given, Objective scored_for)
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
    report.input_contact = boundary.find_contact();
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

  /// Whether skin and inside are evened out for the best shapes. Moves and flips for the sum of gains lead
  /// away from sizes that are wanted.
  bool is_for_shape() const { return options.objective != Objective::kQuality && field.is_empty(); }

  /// Whether the skin is evened out once, when it is coarse, and not on the way.
  bool is_quick() const { return options.effort == 0; }

  /// Whether what the bound permits is there to be spent on shapes.
  bool spends_bound() const { return is_for_shape() && !options.sparing; }

  /// Whether the lengths of the skin's edges are evened out, over the sizes that are wanted, once it was
  /// coarsened, or may be.
  bool evens_boundary() const { return options.objective != Objective::kQuality && takes_boundary(); }

  /// Whether the skin is worked on: where it was coarsened, or where the bound is there to be spent.
  bool takes_boundary() const { return report.surface.collapses > 0 || spends_bound(); }

  void aim_at(double tets) {
    scores = ScoreRule(scale_of(room / std::max(1.0, tets)), field);
    std::fill(mesh.score.begin(), mesh.score.end(), WorkingMesh::kNoScore);  // they were for another aim
  }

  /// Boundary faces whose edges are `boundary_size` times as long as those of so many tets inside.
  std::uint64_t faces_for(double tets) const {
    const double edge = options.boundary_size * std::cbrt(room / (kTetShare * tets));
    return static_cast<std::uint64_t>(std::ceil(area / (kFaceShare * edge * edge)));
  }

  /// The length of edges of a skin of so many boundary faces.
  double edge_of_skin(std::size_t faces) const {
    return std::sqrt(area / (kFaceShare * static_cast<double>(faces)));
  }

  /// Where sizes differ, what is refused in one place must not be made up for in another: no edge that is
  /// longer than wanted is collapsed while there is a plan. Relative to the wanted size.
  double longest_for(double tets, double boundary_size) const {
    if (field.is_empty()) return std::numeric_limits<double>::infinity();
    return boundary_size * std::cbrt(room / (kTetShare * std::max(1.0, tets)));
  }

  /// The other way round: tets that go with the boundary as it is.
  double tets_for_faces() const {
    const double inner = edge_of_skin(boundary.size()) / options.boundary_size;
    return room / (kTetShare * inner * inner * inner);
  }
};

}  // namespace palpate::simplify

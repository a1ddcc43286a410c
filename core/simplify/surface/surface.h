// palpate.surface: boundary and inside coarsened together, the skin within a given distance of the input's
// (the thesis's future work, 4.3.1).
#pragma once

#include "core/mesh/tet_mesh.h"
#include "core/simplify/surface/surface_options.h"

namespace palpate::simplify {

/// Throws: InputError for a ratio outside [0, 1), a bound that is negative or not finite, a boundary_size
/// that is not above 0, a feature_deg outside [0, 180), an effort out of range, or a stop by fusions.
void validate_options(const SurfaceOptions& options);

/// Simplifies a mesh. Every tet stays positive by exact orientation, mesh and boundary stay manifolds of the
/// same topology, no two boundary faces come into contact that were not (so the output is embedded if the
/// input is, which the report says), and the two-sided Hausdorff distance of the boundaries is at most the
/// bound (at least 1e-13 of the largest coordinate, for rounding).
///
/// Boundary and inside are coarsened by turns, in stages. The boundary's edges are to be `boundary_size`
/// times as long as those inside, so a boundary that is already that coarse is left alone, to the bit; where
/// the bound permits no more, the inside goes on alone. The last third of the way is simplify_refined's; if
/// that does not reach the count, the boundary gives way further than planned. Flips and moves in the skin
/// and repairs inside follow. Without a stop, the bound decides how coarse the boundary gets, and the inside
/// follows in the same proportion.
///
/// Features: with feature_deg, the sharp edges of the input's skin stay as lines. Their corners stay to the
/// bit; each line stays one, and the two-sided Hausdorff distance of all lines to the input's is within the
/// same bound.
///
/// Sparing: an eighth of the bound is tried first, then a quarter, half and all of it, each only if the one
/// before did not get the boundary as coarse as wanted. Without it all is taken at once, and (but by q or
/// with sizes) a boundary that is coarse enough is evened out by flips and moves too.
///
/// With kStableStep two runs are made, scored by shapes and by q; the vertices that hold the step down, of a
/// boundary that was coarsened too, are moved in the end, within all of the bound; and the mesh whose
/// greatest frequency is the smaller one is taken (swings_slower).
/// Source: docs/surface.md.
SurfaceRunReport simplify_surface(TetMesh& mesh, const SurfaceOptions& options);

/// For a count that simplify_surface has not reached: the skin as coarse as the bound permits, and inside of
/// it simplify_to_limit. But for a count that is reached after all, what was asked for plays no part, so all
/// counts that are missed end alike. Without a stop it is simplify_surface.
///
/// Time: a run, and some twenty on a mesh of twice the skin's faces. Requires and throws: as
/// simplify_surface.
SurfaceRunReport simplify_surface_to_limit(TetMesh& mesh, const SurfaceOptions& options);

}  // namespace palpate::simplify

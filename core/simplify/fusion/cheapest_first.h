// Fusions ordered by their cost: where they lose least quality for what they remove, over the whole mesh. The
// method palpate.outcome.
#pragma once

#include "core/mesh/tet_mesh.h"
#include "core/simplify/fusion/fusion_options.h"

namespace palpate::simplify {

/// Simplifies `mesh` in place: again and again the candidate of the least cost is fused.
///
///   cost = (sum over the moved tets of (q before - q after) [+ sum over the removed tets of (q - mean q)])
///          / number of tets removed
///
/// with the quality factor q, gains counted as negative losses, over all candidates of all levels; equal
/// costs by number. So that sums do not depend on their order, q is rounded to multiples of 2^-36
/// (batch_quality.h). Candidates are tets of level last_level or higher that pass both checks (and, with
/// skip_touched, that no fusion has moved in this pass).
///
/// All costs are up to date at every fusion: the mesh is the same, to the byte, as if all candidates were
/// weighed anew after each. A candidate is weighed in full once; later a fusion nearby changes a few terms of
/// its sum. Its place in the queue is lazy: a cost that has risen is re-keyed when the candidate comes up.
/// One that fails a check is parked on the moved tet that failed it, its witness, until that changes.
///
/// With regions to keep (common.sizing), a tet that has a vertex of a kept tet is no candidate. Elsewhere the
/// whole is done in several passes under a rising bound on what may grow (GrowthBound), the last one without.
///
/// Requires: a valid mesh (positive tets, manifold faces).
/// Returns:  what was done; `rejected` counts the tets that are left, by what kept them when last looked at.
/// Throws:   InputError for impossible options, or a non-manifold face.
SimplifyReport simplify_cheapest_first(TetMesh& mesh, const CheapestFirstOptions& options);

}  // namespace palpate::simplify

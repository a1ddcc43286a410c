// The thesis's simplifier: worst tet first, from the innermost level outwards (thesis 2.3, 4.2.3).
#pragma once

#include "core/mesh/tet_mesh.h"
#include "core/simplify/fusion/fusion_options.h"

namespace palpate::simplify {

/// Simplifies `mesh` in place.
///
/// For each level from the innermost to options.last_level: while it has a candidate that passes the checks,
/// the one of the lowest quality (ties: lowest number) is fused. Levels are not recomputed. Candidates wait
/// in a heap; one that fails a check is parked on the moved tet that failed it, its witness, and is looked at
/// again only when the witness or the candidate itself changes. That gives the same mesh, to the byte, as
/// scanning all candidates anew after each fusion. About k log n for k looks at candidates; at most 100 bytes
/// a tet with the mesh.
///
/// With regions to keep (options.sizing), a tet that has a vertex of a kept tet is never fused, so that kept
/// tets stay as they are, to the bit. Elsewhere tets grow as the field has it: the levels are gone through in
/// several passes under a rising bound (GrowthBound), the last time without one.
///
/// Requires: a valid mesh (positive tets, manifold faces).
/// Returns:  what was done. A mesh without a candidate is left as it is: stop "limit", 0 fusions.
/// Throws:   InputError for impossible options, or a non-manifold face.
/// Source:   thesis 2.3.3, 2.3.8, 4.2.3.5; docs/errata.md for what is settled otherwise.
SimplifyReport simplify_hierarchical(TetMesh& mesh, const SimplifyOptions& options);

}  // namespace palpate::simplify

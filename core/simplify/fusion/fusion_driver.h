// What all simplifiers that fuse begin and end with.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "core/mesh/tet_mesh.h"
#include "core/simplify/fusion/candidate_queue.h"
#include "core/simplify/fusion/fusion.h"
#include "core/simplify/fusion/fusion_options.h"
#include "core/simplify/sizing/sizing.h"

namespace palpate::simplify {

/// A mesh made ready for fusions.
///
/// Shape:  level and state have one entry a tet of `mesh`. The state is kKept for tets that have a vertex of
///         a kept tet, else kIdle.
struct FusionStart {
  double ideal_volume = 0.0;  ///< mean volume of the input's tets
  SizingField sizing;
  FusionMesh mesh;
  std::vector<std::uint16_t> level;
  std::vector<State> state;
};

/// Simplifies `mesh` in place: makes it ready, has `simplify` fuse (which says in the report how many and why
/// it stopped), counts why the tets that are left were not fused, and takes the mesh out again.
///
/// Requires: valid options (validate_options).
/// Throws:   InputError for a non-manifold face.
SimplifyReport simplify_by_fusions(TetMesh& mesh, const SimplifyOptions& options,
                                   const std::function<void(FusionStart&, SimplifyReport&)>& simplify);

}  // namespace palpate::simplify

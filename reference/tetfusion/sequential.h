// Sequential TetFusion: the first suitable tet of a scan is fused (Chopra and Meyer, IEEE Visualization
// 2002).
#pragma once

#include <cstdint>

#include "core/mesh/tet_mesh.h"
#include "core/simplify/fusion/fusion_options.h"

namespace palpate::reference {

/// The order of the scan.
enum class ScanOrder { kIndex, kReverse, kRandom };

struct SequentialOptions {
  ScanOrder order = ScanOrder::kIndex;
  std::uint64_t seed = 0;  ///< for kRandom
  bool many_passes =
      false;  ///< scan again, with the marks of touched tets cleared, until a scan fuses nothing
  /// The rest is as for the thesis's simplifier, so that both are held to the same checks. skip_touched is
  /// true in the published algorithm.
  simplify::SimplifyOptions common;
};

/// Simplifies `mesh` in place by scanning its tets in `order`. Checks 1 and 2 go by the levels of the input.
///
/// Returns: what was done; `rejected` counts what the last scan met, each tet once.
/// Throws:  InputError for impossible options, or a non-manifold face.
simplify::SimplifyReport simplify_sequentially(TetMesh& mesh, const SequentialOptions& options);

}  // namespace palpate::reference

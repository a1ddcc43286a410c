// The thesis's pseudo-code taken at its word: after every fusion, all candidates of the level are looked at
// anew.
#pragma once

#include "core/simplify/fusion/hierarchical.h"

namespace palpate::test_support {

/// What the naive run did; `refused` counts the candidates that were left when their level, or the run,
/// ended.
struct NaiveReport {
  std::uint64_t fusions = 0;
  std::uint64_t refused = 0;
};

/// Simplifies `mesh` with the same options as simplify_hierarchical, in quadratic time and with plain
/// containers.
NaiveReport simplify_naively(TetMesh& mesh, const simplify::SimplifyOptions& options);

}  // namespace palpate::test_support

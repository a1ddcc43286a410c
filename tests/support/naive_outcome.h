// The order by outcome taken at its word: after every fusion, all candidates are weighed anew.
#pragma once

#include "core/simplify/fusion/outcome.h"

namespace palpate::test_support {

/// Simplifies `mesh` as simplify_by_outcome is documented to, in quadratic time and with plain containers.
/// Returns: the number of fusions.
std::uint64_t simplify_naively_by_outcome(TetMesh& mesh, const simplify::OutcomeOptions& options);

}  // namespace palpate::test_support

// The order by cost taken at its word: after every fusion, all candidates are weighed anew.
#pragma once

#include "core/simplify/fusion/cheapest_first.h"

namespace palpate::test_support {

/// Simplifies `mesh` as simplify_cheapest_first is documented to, in quadratic time and with plain
/// containers. Returns: the number of fusions.
std::uint64_t simplify_naively_cheapest_first(TetMesh& mesh, const simplify::CheapestFirstOptions& options);

}  // namespace palpate::test_support

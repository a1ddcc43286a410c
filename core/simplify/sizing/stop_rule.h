// When a simplifier stops.
#pragma once

#include <cstdint>
#include <optional>

namespace palpate::simplify {

/// When to stop, whichever comes first; without any, at the limit: when nothing more can be fused.
struct StopRule {
  std::optional<std::uint64_t> fusions;  ///< after so many fusions
  std::optional<std::uint64_t> tets;     ///< at the first state with at most so many tets
  std::optional<double> ratio;  ///< at the first state with this share of the tets removed, in [0, 1)
};

/// Fewest tets that a run stopping by tets or ratio may still have to reach; 0 for neither.
std::uint64_t target_tet_count(const StopRule& stop, std::uint64_t tets_in);

/// The stop that a state of a run has reached, "fusions", "tets" or "ratio"; nullptr while there is none.
/// `target` is that of target_tet_count.
const char* reached_stop(const StopRule& stop, std::uint64_t target, std::uint64_t fusions,
                         std::uint64_t tets);

/// The stop by tets or ratio at which a run that went as far as it could has ended, or "limit".
const char* stop_or_limit(const StopRule& stop, std::uint64_t target, std::uint64_t tets);

}  // namespace palpate::simplify

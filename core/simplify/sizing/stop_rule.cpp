#include "core/simplify/sizing/stop_rule.h"

#include <algorithm>
#include <cmath>

namespace palpate::simplify {

std::uint64_t target_tet_count(const StopRule& stop, std::uint64_t tets_in) {
  std::uint64_t target = stop.tets.value_or(0);
  if (stop.ratio) {
    const double removed = std::ceil(*stop.ratio * static_cast<double>(tets_in));
    target = std::max(target, tets_in - static_cast<std::uint64_t>(removed));
  }
  return target;
}

const char* reached_stop(const StopRule& stop, std::uint64_t target, std::uint64_t fusions,
                         std::uint64_t tets) {
  if (stop.fusions && fusions >= *stop.fusions) return "fusions";
  if (target == 0 || tets > target) return nullptr;
  return stop.tets && *stop.tets == target ? "tets" : "ratio";
}

const char* stop_or_limit(const StopRule& stop, std::uint64_t target, std::uint64_t tets) {
  const char* reached = reached_stop(stop, target, 0, tets);
  return reached != nullptr ? reached : "limit";
}

}  // namespace palpate::simplify

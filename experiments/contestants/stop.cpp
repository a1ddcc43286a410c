#include "experiments/contestants/stop.h"

#include "core/base/error.h"

namespace palpate::experiments {

const char* stop_name(StopKind kind) {
  switch (kind) {
    case StopKind::kFusions:
      return "fusions";
    case StopKind::kTets:
      return "tets";
    case StopKind::kRatio:
      return "ratio";
    case StopKind::kLimit:
      return "limit";
    case StopKind::kTetsOf:
      return "tets_of";
  }
  throw ContractError("stop_name: unknown kind");
}

nlohmann::json stop_request(const Stop& stop) {
  require(stop.kind != StopKind::kTetsOf, "stop_request: tets_of is not resolved");
  if (stop.kind == StopKind::kLimit) return {{"limit", true}};
  if (stop.kind == StopKind::kRatio) return {{"ratio", stop.value}};
  return {{stop_name(stop.kind), static_cast<std::int64_t>(stop.value)}};
}

}  // namespace palpate::experiments

#include "experiments/contestants/stop.h"

#include "core/base/enum_names.h"
#include "core/base/error.h"

namespace palpate::experiments {

namespace {

constexpr EnumNames<StopKind, 5> kStopNames{"stop", {"fusions", "tets", "ratio", "limit", "tets_of"}};

}  // namespace

const char* stop_name(StopKind kind) {
  return kStopNames.of(kind);
}

nlohmann::json stop_request(const Stop& stop) {
  require(stop.kind != StopKind::kTetsOf, "stop_request: tets_of is not resolved");
  if (stop.kind == StopKind::kLimit) return {{"limit", true}};
  if (stop.kind == StopKind::kRatio) return {{"ratio", stop.value}};
  return {{stop_name(stop.kind), static_cast<std::int64_t>(stop.value)}};
}

}  // namespace palpate::experiments

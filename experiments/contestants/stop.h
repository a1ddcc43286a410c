// When a simplifier stops.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace palpate::experiments {

enum class StopKind { kFusions, kTets, kRatio, kLimit, kTetsOf };

/// A stop as a plan gives it.
struct Stop {
  StopKind kind = StopKind::kLimit;
  double value = 0.0;  ///< a count, or the share of tets to remove
  std::string of;      ///< kTetsOf: the label whose tets are matched
};

/// A stop's name in plans, requests and records: "fusions", "tets", "ratio", "limit", "tets_of".
const char* stop_name(StopKind kind);

/// The stop as a request and a record say it: {"tets": 100}, {"limit": true}. kTetsOf is not among them.
nlohmann::json stop_request(const Stop& stop);

}  // namespace palpate::experiments

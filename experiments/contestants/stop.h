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
  bool at_its_distance =
      false;  ///< kTetsOf: the skin may stray as far as the answer of that label has, no farther
};

/// The option, in metres, that Stop::at_its_distance sets, and the one that says what the mesh's unit is.
inline constexpr const char* kBoundOfDistance = "max_surface_error_m";
inline constexpr const char* kUnitOfDistance = "unit_m";

/// A stop's name in plans, requests and records: "fusions", "tets", "ratio", "limit", "tets_of".
const char* stop_name(StopKind kind);

/// The stop as a request and a record say it: {"tets": 100}, {"limit": true}. kTetsOf is not among them.
nlohmann::json stop_request(const Stop& stop);

}  // namespace palpate::experiments

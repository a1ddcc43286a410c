#include "experiments/records/untimed.h"

#include <string_view>

#include "experiments/judging/measure.h"

namespace palpate::experiments {

using nlohmann::json;

void drop_times(json& record, const std::string& reason) {
  const auto drop = [&](const std::string& key) {
    const json::json_pointer pointer(key);
    if (!record.contains(pointer) || record.at(pointer).is_null()) return;
    record[pointer] = nullptr;
    record["null_reasons"][key.substr(1)] = reason;
  };
  for (const Measure& measure : list_measures()) {
    if (is_measured_anew(measure) && std::string_view(measure.unit) != "bytes") drop(measure.key);
  }
  for (const char* key : {"/load_1min", "/processor_s", "/others_s"}) drop(key);
}

}  // namespace palpate::experiments

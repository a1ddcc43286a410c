#include "experiments/records/set_aside.h"

#include <string>

#include "core/base/atomic_file.h"
#include "experiments/records/record_file.h"

namespace palpate::experiments {

using nlohmann::json;

bool is_failure(const json& record) {
  const json& outcome = record.at("outcome");
  return outcome != "accepted" && outcome != "rejected";
}

std::size_t set_aside(const std::filesystem::path& records, const std::filesystem::path& aside,
                      const std::function<bool(const json&)>& is_taken) {
  std::error_code error;
  if (!std::filesystem::exists(records, error)) return 0;
  RecordFile retried(aside);
  std::size_t taken = 0;  // all lines are read before the first one moves: a broken one leaves all as it is
  for_each_record(records, [&](const json& record) { taken += is_taken(record) ? 1U : 0U; });
  if (taken == 0) return 0;
  AtomicFile kept(records);
  for_each_record(records, [&](const json& record) {
    if (is_taken(record)) {
      retried.append(record);
    } else {
      kept.write(record_line(record));
    }
  });
  kept.commit();
  return taken;
}

}  // namespace palpate::experiments

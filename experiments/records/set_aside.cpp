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
  std::string kept;
  std::size_t taken = 0;
  {
    RecordFile retried(aside);
    for (const json& record : read_records(records)) {
      if (is_taken(record)) {
        retried.append(record);
        ++taken;
      } else {
        kept += record_line(record);
      }
    }
  }
  if (taken > 0) write_file_atomically(records, kept);
  return taken;
}

}  // namespace palpate::experiments

#include "experiments/runner/repeat_end.h"

#include "core/base/error.h"
#include "core/base/plain_file.h"
#include "experiments/files/file_hash.h"
#include "experiments/files/plain_file.h"
#include "experiments/processes/disk_room.h"
#include "experiments/records/set_aside.h"
#include "reference/door/json_file.h"

namespace palpate::experiments {
namespace fs = std::filesystem;

using nlohmann::json;
using reference::or_null;

void throw_if_no_room(const fs::path& scratch, const json& record) {
  if (scratch.empty() || !is_failure(record)) return;
  const std::string message = record.at("message").get<std::string>();
  const std::string no_room = room_complaint(scratch, message);
  if (!no_room.empty()) throw UnavailableError(no_room + "; " + message);
}

void add_load(const MachineLoad& load, const ContestantAnswer& answer, json& record) {
  const bool is_known = answer.user_s.has_value();
  record["load_1min"] = or_null(load.load_1min);
  record["processor_s"] = is_known ? or_null(load.processor_s) : json();
  record["others_s"] = is_known ? or_null(load.others_s) : json();
}

void add_file_hashes(const MethodSpec& method, const Case& c, json& record) {
  for (const OptionSpec& option : method.options) {
    if (option.type != OptionType::kFile || !c.options.contains(option.name)) continue;
    const std::string file = c.options.at(option.name).get<std::string>();
    std::error_code error;
    if (file.empty()) continue;
    if (fs::is_regular_file(file, error)) record["files"][option.name] = hash_file(file);
    record["options"][option.name] = fs::path(file).filename().string();
  }
}

fs::path beside_path(const fs::path& kept, const std::string& name) {
  return fs::path(kept).replace_extension("." + name);
}

void keep_beside(const fs::path& output, const fs::path& kept, const std::string& name) {
  if (name.empty()) return;
  std::error_code error;
  const fs::path beside = output.parent_path() / name;
  if (!file_complaint(beside).empty()) return;
  fs::rename(beside, beside_path(kept, name), error);
  if (!error) sync_to_disk(beside_path(kept, name));
}

}  // namespace palpate::experiments

#include "experiments/runner/taken_parts.h"

#include <algorithm>
#include <array>

#include "core/base/error.h"
#include "core/base/plain_file.h"
#include "experiments/files/file_hash.h"
#include "experiments/files/output_file.h"
#include "experiments/files/plain_file.h"
#include "experiments/records/provenance.h"
#include "experiments/records/untimed.h"
#include "experiments/runner/repeat_end.h"

namespace palpate::experiments {
namespace fs = std::filesystem;
namespace {

using nlohmann::json;

constexpr std::array<const char*, 4> kNodeKeys{"processor", "processors", "memory", "system"};
constexpr const char* kTakenTimes = "times_are_of_parts";  // of a provenance

std::pair<std::string, int> repeat_key(const json& record) {
  return {record.at("case").get<std::string>(), record.at("repeat").get<int>()};
}

bool is_answer(const json& record) {
  return !record.at("contestant").is_null();
}

bool is_run(const fs::path& folder) {
  std::error_code error;
  return fs::is_regular_file(folder / "provenance.json", error) &&
         fs::is_regular_file(folder / "records.jsonl", error);
}

json read_part(const fs::path& part) {
  if (!is_run(part)) throw InputError(part.string(), 0, "the folder of a run", "none");
  json value = read_provenance(part / "provenance.json");
  if (value.value("schema", json()) != "palpate/provenance/1")
    throw InputError((part / "provenance.json").string(), 0, "a provenance (palpate/provenance/1)",
                     value.value("schema", json()).dump());
  return value;
}

/// Meshes and problems by name, as far as they say what a case was asked.
std::map<std::string, json> inputs_of(const json& provenance) {
  std::map<std::string, json> inputs;
  for (const json& mesh : provenance.value("meshes", json::array())) {
    if (mesh.contains("name"))
      inputs["mesh " + mesh.at("name").get<std::string>()] = mesh.value("hash", json());
  }
  const json problems = provenance.value("problems", json::object());
  for (const auto& [id, problem] : problems.items()) inputs["problem " + id] = problem;
  return inputs;
}

}  // namespace

json node_kind(const json& provenance) {
  json kind = json::object();
  for (const char* key : kNodeKeys) kind[key] = provenance.value(key, json());
  return kind;
}

json moved_here(json then, const json& now) {
  if (then.value(kTakenTimes, json()) == true) then.update(node_kind(now));
  return then;
}

std::vector<fs::path> list_parts(const fs::path& folder) {
  std::vector<fs::path> parts;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (is_run(entry.path())) parts.push_back(entry.path());
  }
  std::sort(parts.begin(), parts.end());
  return parts;
}

std::vector<fs::path> find_parts(const fs::path& folder) {
  std::vector<fs::path> below;
  if (!is_run(folder)) below = list_parts(folder);
  return below.empty() ? std::vector<fs::path>{folder} : below;
}

void check_parts(const fs::path& folder) {
  for (const fs::path& part : find_parts(folder)) read_part(part);
}

PartTaker::PartTaker(const RunPaths& paths, std::map<std::string, fs::path> kept, std::string beside_file,
                     json& provenance, std::function<void()> save)
    : paths_(paths),
      kept_(std::move(kept)),
      beside_file_(std::move(beside_file)),
      provenance_(provenance),
      save_(std::move(save)) {
  for_each_record(paths.records(), [this](const json& record) {
    recorded_.insert(repeat_key(record));
    is_timed_ = is_timed_ || is_answer(record);
  });
}

void PartTaker::check(const fs::path& part, const json& theirs) const {
  std::string differs;
  json machine = theirs;  // a part may have run elsewhere
  for (const char* key : kNodeKeys) machine[key] = provenance_.value(key, json());
  for (const std::string& change : find_changes(machine, provenance_)) differs += "; " + change;
  const auto mine = inputs_of(provenance_);
  for (const auto& [name, input] : inputs_of(theirs)) {
    const auto found = mine.find(name);
    if (found != mine.end() && found->second != input) differs += "; the " + name + " is another";
  }
  if (!differs.empty()) throw InputError(part.string() + ": this part cannot be taken" + differs);
}

/// Appends the sittings of a part, each with its kind of node, or finds them where a killed run left them.
/// Returns: the place of the first.
std::size_t PartTaker::add_sittings(const json& theirs) const {
  std::vector<json> added;
  for (json sitting : theirs.value("sittings", json::array())) {
    sitting["node"] = node_kind(theirs);
    added.push_back(std::move(sitting));
  }
  json& all = provenance_.at("sittings");
  const auto found = std::search(all.begin(), all.end(), added.begin(), added.end());
  const auto place = static_cast<std::size_t>(found - all.begin());
  if (found == all.end()) {
    for (json& sitting : added) all.push_back(std::move(sitting));
  }
  return place;
}

/// Copies an output whose hash is `hash`. It appears whole, and lies on the disk, before its record is there.
void PartTaker::take_output(const fs::path& part, const fs::path& kept, const json& record,
                            const json& hash) const {
  const std::string records = (part / "records.jsonl").string();
  const std::string id = record.at("case").get<std::string>();
  const fs::path name = kept.lexically_relative(paths_.folder);
  if (record.at("mesh_file") != name.string())
    throw InputError(records, 0, "the output of " + id + " at " + name.string(),
                     record.at("mesh_file").dump());
  if (!hash.is_string())
    throw InputError(records, 0, "the hash of the output of " + id + " in its repeat 0", "none");
  const fs::path from = part / name;
  std::error_code error;
  if (!fs::is_regular_file(fs::symlink_status(from, error)))
    throw InputError(from.string(), 0, "the output that its record names", "none");
  if (const std::uintmax_t size = fs::file_size(from, error); error || size > kLargestFile)
    throw InputError(from.string(), 0, "an output of at most " + std::to_string(kLargestFile) + " bytes",
                     error ? error.message() : std::to_string(size));
  create_folder(kept.parent_path());
  copy_file_atomically(from, kept, [&](const fs::path& copy) {
    if (json(hash_file(copy)) != hash)
      throw InputError(from.string(), 0, "an output whose hash is " + hash.dump(), "another one");
  });
  if (beside_file_.empty()) return;
  const fs::path beside = beside_path(kept, beside_file_);
  const fs::path theirs = part / beside.lexically_relative(paths_.folder);
  if (fs::is_regular_file(fs::symlink_status(theirs, error)) && fs::file_size(theirs, error) <= kLargestFile)
    copy_file_atomically(theirs, beside, [](const fs::path&) {});  // to be looked at alone
}

std::size_t PartTaker::take(const fs::path& part, RecordFile& records) {
  const json theirs = read_part(part);
  const FolderLock lock(part);  // nobody writes to it any more
  check(part, theirs);
  const json kind = node_kind(theirs);
  const std::size_t sittings = theirs.value("sittings", json::array()).size();
  const fs::path theirs_file = part / "records.jsonl";
  // All lines are read before anything is taken: a broken one leaves the run as it is.
  std::map<std::string, json> hashes;  // of outputs, by case: what repeat 0 made is kept
  bool is_new = false;
  bool brings_times = false;
  for_each_record(theirs_file, [&](const json& record) {
    const auto key = repeat_key(record);
    if (key.second == 0) hashes[key.first] = record.value("output_hash", json());
    if (is_answer(record) && kept_.count(key.first) == 0)
      throw InputError(theirs_file.string(), 0, "cases of the plan", key.first);
    if (record.value("sitting", std::size_t{0}) >= std::max<std::size_t>(1, sittings))
      throw InputError(theirs_file.string(), 0, "one of the run's " + std::to_string(sittings) + " sittings",
                       record.at("sitting").dump());
    const bool is_missing = recorded_.count(key) == 0;
    is_new = is_new || is_missing;
    brings_times = brings_times || (is_missing && is_answer(record));
  });
  if (!is_new) return 0;
  if (!is_timed_ && brings_times && kind != node_kind(provenance_)) {
    provenance_.update(kind);  // the run's times are those of its first part's node
    provenance_[kTakenTimes] = true;
  }
  const json timed_on = node_kind(provenance_);
  const std::size_t first_sitting = add_sittings(theirs);
  save_();
  std::size_t taken = 0;
  for_each_record(theirs_file, [&](json record) {
    const auto key = repeat_key(record);
    if (recorded_.count(key) > 0) return;
    if (is_answer(record) && record.value("mesh_file", json()).is_string()) {
      const fs::path& kept = kept_.at(key.first);
      const json& hash = hashes[key.first];
      // A run that was killed may have left the output of a repeat that has no record.
      const bool is_there = fs::exists(kept) && (key.second != 0 || json(hash_file(kept)) == hash);
      if (!is_there) take_output(part, kept, record, hash);
    }
    if (kind != timed_on)
      drop_times(record,
                 "timed on another kind of node (" + kind.at("processor").dump() + ") than the run's others");
    record["sitting"] = first_sitting + record.value("sitting", std::size_t{0});
    records.append(record);
    recorded_.insert(key);
    is_timed_ = is_timed_ || is_answer(record);
    ++taken;
  });
  return taken;
}

}  // namespace palpate::experiments

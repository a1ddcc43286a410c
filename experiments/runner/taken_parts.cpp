#include "experiments/runner/taken_parts.h"

#include <algorithm>
#include <array>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "experiments/files/file_hash.h"
#include "experiments/files/output_file.h"
#include "experiments/records/provenance.h"
#include "experiments/records/untimed.h"
#include "experiments/runner/repeat_end.h"
#include "reference/door/json_file.h"

namespace palpate::experiments {
namespace fs = std::filesystem;
namespace {

using nlohmann::json;

constexpr std::array<const char*, 4> kNodeKeys{"processor", "processors", "memory", "system"};

bool is_run(const fs::path& folder) {
  std::error_code error;
  return fs::is_regular_file(folder / "provenance.json", error) &&
         fs::is_regular_file(folder / "records.jsonl", error);
}

json read_provenance(const fs::path& part) {
  if (!is_run(part)) throw InputError(part.string(), 0, "the folder of a run", "none");
  json value = reference::read_json_file(part / "provenance.json");
  if (!value.is_object())
    throw InputError((part / "provenance.json").string(), 0, "the provenance of a run", "something else");
  return value;
}

/// Meshes and problems by name, as far as they say what a case was asked.
std::map<std::string, json> inputs_of(const json& provenance) {
  std::map<std::string, json> inputs;
  for (const json& mesh : provenance.value("meshes", json::array())) {
    if (mesh.is_object() && mesh.contains("name"))
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

PartTaker::PartTaker(const RunPaths& paths, std::map<std::string, fs::path> kept, std::string beside_file,
                     json& provenance)
    : paths_(paths), kept_(std::move(kept)), beside_file_(std::move(beside_file)), provenance_(provenance) {
  for_each_record(paths.records(), [this](const json& record) {
    recorded_.emplace(record.at("case").get<std::string>(), record.at("repeat").get<int>());
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

/// Copies an output that the run has not yet. It appears whole or not at all.
void PartTaker::take_output(const fs::path& part, const fs::path& kept, const json& record) const {
  const fs::path name = kept.lexically_relative(paths_.folder);
  if (record.at("mesh_file") != name.string())
    throw InputError((part / "records.jsonl").string(), 0,
                     "the output of " + record.at("case").get<std::string>() + " at " + name.string(),
                     record.at("mesh_file").dump());
  const fs::path from = part / name;
  std::error_code error;
  if (!fs::is_regular_file(fs::symlink_status(from, error)))
    throw InputError(from.string(), 0, "the output that its record names", "none");
  create_folder(kept.parent_path());
  fs::path unfinished = kept;
  unfinished += ".part";
  fs::copy_file(from, unfinished, fs::copy_options::overwrite_existing, error);
  if (error) fail_to_write(unfinished, "a file that can be written", error.value());
  if (record.at("repeat") == 0 && json(hash_file(unfinished)) != record.at("output_hash")) {
    fs::remove(unfinished, error);
    throw InputError(from.string(), 0, "an output whose hash is " + record.at("output_hash").dump(),
                     "another one");
  }
  fs::rename(unfinished, kept);
  if (beside_file_.empty()) return;
  const fs::path beside = beside_path(kept, beside_file_);
  const fs::path theirs = part / beside.lexically_relative(paths_.folder);
  if (fs::is_regular_file(fs::symlink_status(theirs, error)))
    fs::copy_file(theirs, beside, fs::copy_options::overwrite_existing, error);  // to be looked at alone
}

std::size_t PartTaker::take(const fs::path& part, RecordFile& records) {
  const json theirs = read_provenance(part);
  const FolderLock lock(part);  // nobody writes to it any more
  check(part, theirs);
  const json kind = node_kind(theirs);
  if (recorded_.empty()) provenance_.update(kind);  // the run's times are those of its first part's node
  const json timed_on = node_kind(provenance_);
  const std::size_t first_sitting = provenance_.at("sittings").size();
  std::size_t taken = 0;
  const auto take_record = [&](json record) {
    const std::pair<std::string, int> key{record.at("case").get<std::string>(),
                                          record.at("repeat").get<int>()};
    if (recorded_.count(key) > 0) return;
    const auto kept = kept_.find(key.first);
    const bool is_case = !record.at("contestant").is_null();
    if (is_case && kept == kept_.end())
      throw InputError((part / "records.jsonl").string(), 0, "cases of the plan", key.first);
    if (is_case && record.at("mesh_file").is_string() && !fs::exists(kept->second))
      take_output(part, kept->second, record);
    if (kind != timed_on)
      drop_times(record,
                 "timed on another kind of node (" + kind.at("processor").dump() + ") than the run's others");
    record["sitting"] = first_sitting + record.value("sitting", std::size_t{0});
    records.append(record);
    recorded_.insert(key);
    ++taken;
  };
  const fs::path theirs_file = part / "records.jsonl";
  for_each_record(theirs_file, [](const json&) {});  // a broken line is found before anything is taken
  for_each_record(theirs_file, take_record);
  for (json sitting : theirs.value("sittings", json::array())) {
    sitting["node"] = kind;
    provenance_["sittings"].push_back(std::move(sitting));
  }
  return taken;
}

}  // namespace palpate::experiments

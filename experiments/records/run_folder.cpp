#include "experiments/records/run_folder.h"

#include <algorithm>
#include <cerrno>
#include <cstdlib>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "experiments/files/output_file.h"
#include "experiments/files/places.h"
#include "experiments/records/provenance.h"
#include "experiments/records/source_version.h"
#include "reference/door/json_file.h"

namespace palpate::experiments {
namespace fs = std::filesystem;
namespace {

bool holds_run(const fs::path& folder) {
  std::error_code error;
  return fs::exists(folder / "records.jsonl", error);
}

/// Removes what is in a folder, folders that nobody may write included, as far as that can be done.
void empty_folder(const fs::path& folder) {
  std::error_code error;
  fs::remove_all(folder, error);
  if (!error) return;
  auto at = fs::recursive_directory_iterator(folder, error);
  for (; !error && at != fs::end(at); at.increment(error)) {
    std::error_code own;
    if (fs::is_directory(at->symlink_status(own))) fs::permissions(at->path(), fs::perms::owner_all, own);
  }
  fs::remove_all(folder, error);
}

}  // namespace

RunFolder::RunFolder(const fs::path& folder, bool resume) : paths_{folder}, resume_(resume) {
  create_folder(folder);
  // A run that was killed at its very start has left a lock file, and perhaps nothing else.
  const bool ours = fs::exists(folder / ".lock") || fs::is_empty(folder);
  if (!ours) throw InputError(folder.string(), 0, "an empty folder or a run", "other files");
  lock_.emplace(folder);
  std::error_code error;
  const auto recorded = fs::file_size(paths_.records(), error);
  if (!error && recorded > 0 && !resume) {
    throw InputError(folder.string() +
                     ": holds a run already; --resume continues it, another --out starts anew");
  }
  create_folder(folder / "meshes");
}

RunFolder::~RunFolder() {
  empty_folder(paths_.scratch());
  std::error_code ignored;
  fs::remove(paths_.scratch(), ignored);
}

std::optional<nlohmann::json> RunFolder::earlier_provenance() const {
  if (!resume_ || !fs::exists(paths_.provenance())) return std::nullopt;
  nlohmann::json value = reference::read_json_file(paths_.provenance());
  if (!value.is_object()) {
    throw InputError(paths_.provenance().string(), 0, "the provenance of a run", "something else");
  }
  return value;
}

fs::path RunFolder::fresh_scratch() const {
  empty_folder(paths_.scratch());
  create_folder(paths_.scratch());
  std::string fresh = (paths_.scratch() / "XXXXXX").string();
  if (::mkdtemp(fresh.data()) == nullptr)
    fail_to_write(paths_.scratch(), "a folder that can be written", errno);
  return fresh;
}

fs::path results_folder(const std::string& plan_name) {
  return results_root() / plan_name;
}

fs::path new_run_folder(const fs::path& parent) {
  const std::string name = utc_now(true) + "-" + find_source_version().commit;
  fs::path folder = parent / name;
  for (int i = 2; fs::exists(folder); ++i) folder = parent / (name + "-" + std::to_string(i));
  return folder;
}

fs::path find_run(const fs::path& folder) {
  std::error_code error;
  if (!fs::is_directory(folder, error)) throw InputError(folder.string(), 0, "the folder of a run", "none");
  if (holds_run(folder)) return folder;
  std::vector<fs::path> runs;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (holds_run(entry.path())) runs.push_back(entry.path());
  }
  if (runs.empty()) throw InputError(folder.string(), 0, "a run (with records.jsonl)", "none");
  return *std::max_element(runs.begin(), runs.end());
}

}  // namespace palpate::experiments

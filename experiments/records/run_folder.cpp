#include "experiments/records/run_folder.h"

#include <sys/types.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <cstdlib>
#include <string_view>
#include <vector>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/plain_file.h"
#include "experiments/files/output_file.h"
#include "experiments/files/places.h"
#include "experiments/files/remove_tree.h"
#include "experiments/records/provenance.h"
#include "experiments/records/source_version.h"

namespace palpate::experiments {
namespace fs = std::filesystem;
namespace {

bool holds_run(const fs::path& folder) {
  std::error_code error;
  return fs::exists(folder / "records.jsonl", error);
}

/// The process that a half-written file is of; nothing for another file.
std::optional<pid_t> writer_of(const std::string& name) {
  const std::size_t mark = name.rfind(kPartialMark);
  if (mark == std::string::npos) return std::nullopt;
  const char* const first = name.data() + mark + std::string_view(kPartialMark).size();
  const char* const last = name.data() + name.size();
  pid_t process = 0;
  const auto [end, error] = std::from_chars(first, last, process);
  const bool is_number = error == std::errc() && end == last && process > 0;
  return is_number ? std::optional(process) : std::nullopt;
}

/// Removes what processes that are gone have half written; not where nobody may look. Left out is what is
/// emptied without following a link (`scratch`), and what lies in parts, which are runs of their own and look
/// themselves.
/// Throws: InputError for a link, however deep: a run that somebody else packed would have files written and
///         removed wherever it leads.
void tidy_up(const RunPaths& paths) {
  std::error_code error;
  auto at =
      fs::recursive_directory_iterator(paths.folder, fs::directory_options::skip_permission_denied, error);
  for (; !error && at != fs::end(at); at.increment(error)) {
    std::error_code own;
    const fs::file_type type = at->symlink_status(own).type();
    if (type == fs::file_type::symlink)
      throw InputError(at->path().string(), 0, "a run's own file or folder", "a link");
    const bool is_of_others =
        at->path() == paths.scratch() || (at.depth() == 1 && at->path().parent_path() == paths.parts());
    if (is_of_others) at.disable_recursion_pending();
    const auto writer = writer_of(at->path().filename().string());
    if (!writer || type != fs::file_type::regular) continue;
    if (::kill(*writer, 0) != 0 && errno == ESRCH) fs::remove(at->path(), own);
  }
}

}  // namespace

RunFolder::RunFolder(const fs::path& folder, bool resume) : paths_{folder}, resume_(resume) {
  create_folder(folder);
  // A run that was killed at its very start has left a lock file, and perhaps nothing else.
  const bool ours = fs::exists(folder / ".lock") || fs::is_empty(folder);
  if (!ours) throw InputError(folder.string(), 0, "an empty folder or a run", "other files");
  lock_.emplace(folder);
  tidy_up(paths_);
  std::error_code error;
  const auto recorded = fs::file_size(paths_.records(), error);
  if (!error && recorded > 0 && !resume) {
    throw InputError(folder.string() +
                     ": holds a run already; --resume continues it, another --out starts anew");
  }
  create_folder(folder / "meshes");
}

RunFolder::~RunFolder() {
  remove_folder(paths_.scratch());
}

std::optional<nlohmann::json> RunFolder::earlier_provenance() const {
  if (!resume_) return std::nullopt;
  std::error_code error;
  if (fs::exists(paths_.provenance(), error)) return read_provenance(paths_.provenance());
  const auto recorded = fs::file_size(paths_.records(), error);
  if (!error && recorded > 0)
    throw InputError(paths_.provenance().string(), 0,
                     "what the records beside it were made with, to continue the run", "none");
  return std::nullopt;
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

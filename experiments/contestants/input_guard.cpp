#include "experiments/contestants/input_guard.h"

#include <algorithm>
#include <optional>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "experiments/files/file_bytes.h"
#include "experiments/files/plain_file.h"

namespace palpate::experiments {
namespace fs = std::filesystem;
namespace {

/// Whether the file holds these bytes still. One of another size is not read, and no link is followed.
bool holds(const fs::path& file, const std::string& bytes) {
  std::error_code error;
  return is_plain_file(file) && fs::file_size(file, error) == bytes.size() && !error &&
         read_bytes(file) == bytes;
}

}  // namespace

void InputGuard::watch(const fs::path& file) {
  std::error_code error;
  if (!fs::exists(file, error)) return;
  auto bytes = read_bytes(file);
  if (!bytes) throw InputError(file.string(), 0, "a readable file", "none");
  const fs::path own = fs::canonical(file, error);  // a user's own link is followed once, now
  watched_.push_back({error ? file : own, *std::move(bytes), false});
}

fs::path InputGuard::copy(const fs::path& file, const fs::path& folder) {
  const std::size_t before = watched_.size();
  watch(file);
  if (watched_.size() == before) return file;
  fs::path place = folder / file.filename();
  std::error_code error;
  fs::create_directories(folder, error);
  write_file_atomically(place, watched_.back().bytes);
  fs::permissions(place, fs::perms::owner_read | fs::perms::group_read | fs::perms::others_read, error);
  Watched copied = watched_.back();
  copied.file = place;
  copied.is_copy = true;
  watched_.push_back(std::move(copied));
  return place;
}

std::vector<std::string> InputGuard::restore() const {
  std::vector<std::string> changed;
  for (const Watched& watched : watched_) {
    if (holds(watched.file, watched.bytes)) continue;
    const std::string name = watched.file.filename().string();
    if (std::find(changed.begin(), changed.end(), name) == changed.end()) changed.push_back(name);
    if (watched.is_copy) continue;
    std::error_code error;
    if (!is_plain_file(watched.file)) fs::remove_all(watched.file, error);  // a link itself, not its end
    write_file_atomically(watched.file, watched.bytes);
  }
  return changed;
}

}  // namespace palpate::experiments

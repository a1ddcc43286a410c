#include "experiments/contestants/input_guard.h"

#include <algorithm>
#include <fstream>
#include <optional>
#include <sstream>

#include "core/base/atomic_file.h"
#include "core/base/error.h"

namespace palpate::experiments {
namespace fs = std::filesystem;
namespace {

/// A file's bytes; nothing if it cannot be read.
std::optional<std::string> read_whole(const fs::path& path) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return std::nullopt;
  std::ifstream file(path, std::ios::binary);
  if (!file) return std::nullopt;
  std::ostringstream bytes;
  if (fs::file_size(path, error) > 0) bytes << file.rdbuf();
  return file.bad() ? std::nullopt : std::optional(std::move(bytes).str());
}

}  // namespace

void InputGuard::watch(const fs::path& file) {
  std::error_code error;
  if (!fs::exists(file, error)) return;
  auto bytes = read_whole(file);
  if (!bytes) throw InputError(file.string(), 0, "a readable file", "none");
  watched_.push_back({file, *std::move(bytes), false});
}

fs::path InputGuard::copy(const fs::path& file, const fs::path& folder) {
  watch(file);
  if (watched_.empty() || watched_.back().file != file) return file;
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
    if (read_whole(watched.file) == watched.bytes) continue;
    const std::string name = watched.file.filename().string();
    if (std::find(changed.begin(), changed.end(), name) == changed.end()) changed.push_back(name);
    if (!watched.is_copy) write_file_atomically(watched.file, watched.bytes);
  }
  return changed;
}

}  // namespace palpate::experiments

#include "experiments/contestants/input_guard.h"

#include <algorithm>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/plain_file.h"
#include "experiments/files/file_hash.h"
#include "experiments/files/plain_file.h"

namespace palpate::experiments {
namespace fs = std::filesystem;

void InputGuard::watch(const fs::path& file) {
  std::error_code error;
  if (!fs::exists(file, error)) return;
  Watched watched;
  watched.file = fs::canonical(file, error);  // a user's own link is followed once, now
  if (error) watched.file = file;
  if (!fs::is_regular_file(watched.file, error))
    throw InputError(file.string(), 0, "a readable file", "none");
  watched.size = fs::file_size(watched.file, error);
  if (watched.size <= most_kept_) {
    watched.bytes = read_bytes(watched.file);
    if (!watched.bytes) throw InputError(file.string(), 0, "a readable file", "none");
    watched.size = watched.bytes->size();
  } else {
    watched.hash = hash_file(watched.file);
  }
  watched_.push_back(std::move(watched));
}

fs::path InputGuard::copy(const fs::path& file, const fs::path& folder) {
  const std::size_t before = watched_.size();
  watch(file);
  if (watched_.size() == before) return file;
  fs::path place = folder / file.filename();
  std::error_code error;
  fs::create_directories(folder, error);
  Watched copied = watched_.back();
  if (copied.bytes) {
    write_file_atomically(place, *copied.bytes);
  } else {
    copy_file_atomically(copied.file, place, [](const fs::path&) {});
  }
  fs::permissions(place, fs::perms::owner_read | fs::perms::group_read | fs::perms::others_read, error);
  copied.file = place;
  copied.is_copy = true;
  watched_.push_back(std::move(copied));
  return place;
}

/// One of another size is not read, and no link is followed.
bool InputGuard::Watched::is_as_it_was() const {
  std::error_code error;
  if (!is_plain_file(file) || fs::file_size(file, error) != size || error) return false;
  return bytes ? read_bytes(file) == bytes : hash_file(file) == hash;
}

void InputGuard::put_back(const Watched& watched) const {
  const auto same = std::find_if(watched_.begin(), watched_.end(), [&](const Watched& other) {
    return other.is_copy && other.size == watched.size && other.hash == watched.hash && other.is_as_it_was();
  });
  if (!watched.bytes && same == watched_.end()) {
    throw InputError(
        watched.file.string(), 0,
        "the input as it was (of " + std::to_string(watched.size) + " bytes, too large to be kept)",
        "one that a contestant has changed");
  }
  std::error_code error;
  if (!is_plain_file(watched.file)) fs::remove_all(watched.file, error);  // a link itself, not its end
  if (watched.bytes) {
    write_file_atomically(watched.file, *watched.bytes);
  } else {
    copy_file_atomically(same->file, watched.file, [](const fs::path&) {});
    fs::permissions(watched.file, fs::perms::owner_write, fs::perm_options::add, error);
  }
}

std::vector<std::string> InputGuard::restore() const {
  std::vector<std::string> changed;
  for (const Watched& watched : watched_) {
    if (watched.is_as_it_was()) continue;
    const std::string name = watched.file.filename().string();
    if (std::find(changed.begin(), changed.end(), name) == changed.end()) changed.push_back(name);
    if (!watched.is_copy) put_back(watched);
  }
  return changed;
}

}  // namespace palpate::experiments

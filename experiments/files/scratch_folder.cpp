#include "experiments/files/scratch_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <string_view>
#include <system_error>

#include "core/base/error.h"
#include "experiments/files/remove_tree.h"

namespace palpate::experiments {

namespace fs = std::filesystem;
namespace {

constexpr std::string_view kName = "palpate-scratch-";

/// A folder locked for this program, or -1: it is another's, or none.
int lock_folder(const fs::path& folder) {
  const int file = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC | O_NOFOLLOW);
  if (file >= 0 && ::flock(file, LOCK_EX | LOCK_NB) == 0) return file;
  if (file >= 0) ::close(file);
  return -1;
}

bool is_own(const fs::path& folder) {
  struct stat facts {};
  return ::lstat(folder.c_str(), &facts) == 0 && S_ISDIR(facts.st_mode) && facts.st_uid == ::geteuid();
}

/// Removes this user's scratch folders that nobody holds. Young ones stay: they may not be locked yet.
void sweep(const fs::path& base) {
  constexpr auto kYoung = std::chrono::minutes(10);
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(base, ignored)) {
    if (!entry.path().filename().string().starts_with(kName) || !is_own(entry.path())) continue;
    const auto changed = fs::last_write_time(entry.path(), ignored);
    if (fs::file_time_type::clock::now() - changed < kYoung) continue;
    const int lock = lock_folder(entry.path());
    if (lock < 0) continue;
    remove_folder(entry.path());
    ::close(lock);
  }
}

}  // namespace

ScratchFolder::ScratchFolder() {
  std::error_code error;
  fs::path base = fs::temp_directory_path(error);
  if (error) base = "/tmp";
  sweep(base);
  std::string pattern = (base / "palpate-scratch-XXXXXX").string();
  if (::mkdtemp(pattern.data()) == nullptr) throw UnavailableError("cannot make a scratch folder " + pattern);
  path_ = pattern;
  lock_ = lock_folder(path_);
}

ScratchFolder::~ScratchFolder() {
  remove_folder(path_);
  if (lock_ >= 0) ::close(lock_);
}

}  // namespace palpate::experiments

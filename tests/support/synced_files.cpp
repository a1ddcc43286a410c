#include "tests/support/synced_files.h"

#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <mutex>
#include <string>

namespace palpate::test {
namespace {

std::mutex guard;
bool is_noted = false;
std::vector<std::filesystem::path> noted;

}  // namespace

SyncedFiles::SyncedFiles() {
  const std::lock_guard lock(guard);
  noted.clear();
  is_noted = true;
}

SyncedFiles::~SyncedFiles() {
  const std::lock_guard lock(guard);
  is_noted = false;
}

std::vector<std::filesystem::path> SyncedFiles::paths() const {
  const std::lock_guard lock(guard);
  return noted;
}

/// Stands in the place of the system's fsync, which it calls.
extern "C" int fsync(int file) {
  {
    const std::lock_guard lock(guard);
    std::error_code error;
    if (is_noted)
      noted.push_back(std::filesystem::read_symlink("/proc/self/fd/" + std::to_string(file), error));
  }
  return static_cast<int>(::syscall(SYS_fsync, file));
}

}  // namespace palpate::test

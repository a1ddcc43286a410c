#include "core/base/synced_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <system_error>

#include "core/base/atomic_file.h"

namespace palpate {
namespace fs = std::filesystem;

void sync_to_disk(const fs::path& path) {
  const fs::path folder = path.has_parent_path() ? path.parent_path() : ".";
  for (const fs::path& each : {path, folder}) {
    const int file = ::open(each.c_str(), O_RDONLY | O_CLOEXEC);
    const bool is_synced =
        file >= 0 && (::fsync(file) == 0 || errno == EINVAL || errno == EROFS || errno == ENOTSUP);
    const int reason = errno;
    if (file >= 0) ::close(file);
    if (!is_synced) fail_to_write(each, "a file that can be flushed to the disk", reason);
  }
}

void copy_file_atomically(const fs::path& from, const fs::path& to,
                          const std::function<void(const fs::path& copy)>& check) {
  fs::path copy = to;
  copy += kPartialMark + std::to_string(::getpid());
  std::error_code error;
  try {
    fs::copy_file(from, copy, fs::copy_options::overwrite_existing, error);
    if (error) fail_to_write(copy, "a file that can be written", error.value());
    check(copy);
    sync_to_disk(copy);
    fs::rename(copy, to, error);
    if (error) fail_to_write(to, "a file that can be written", error.value());
  } catch (...) {
    fs::remove(copy, error);
    throw;
  }
  sync_to_disk(to);
}

}  // namespace palpate

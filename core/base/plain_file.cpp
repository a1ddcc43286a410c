#include "core/base/plain_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <system_error>

#include "core/base/atomic_file.h"
#include "core/base/error.h"

namespace palpate {
namespace fs = std::filesystem;

const char* file_kind(mode_t mode) {
  if (S_ISLNK(mode)) return "a link";
  if (S_ISDIR(mode)) return "a folder";
  if (S_ISFIFO(mode)) return "a pipe";
  if (S_ISSOCK(mode)) return "a socket";
  return S_ISREG(mode) ? "" : "a device";
}

void refuse_no_file(const std::filesystem::path& path, const std::string& expected) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0 || S_ISREG(status.st_mode)) return;
  throw InputError(path.string(), 0, expected, file_kind(status.st_mode));
}

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

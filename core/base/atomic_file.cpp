#include "core/base/atomic_file.h"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

#include "core/base/error.h"

namespace palpate {

void fail_to_write(const std::filesystem::path& path, const std::string& expected, int reason) {
  const std::string found = std::strerror(reason);
  const bool is_full = reason == ENOSPC || reason == EDQUOT || reason == EFBIG;  // EFBIG: `ulimit -f`
  if (is_full) throw NoRoomError(path.string(), 0, expected, found);
  throw InputError(path.string(), 0, expected, found);
}

AtomicFile::AtomicFile(std::filesystem::path path) : path_(std::move(path)) {
  std::error_code ignored;
  // Through a link to the file itself: renaming would replace the link.
  if (std::filesystem::is_symlink(path_, ignored)) {
    std::filesystem::path target = std::filesystem::canonical(path_, ignored);
    if (!ignored) path_ = std::move(target);
  }
  if (std::filesystem::is_directory(path_, ignored)) {
    throw InputError(path_.string(), 0, "a file to write", "a folder");
  }
  is_special_ = std::filesystem::is_other(path_, ignored);
  partial_ = is_special_ ? path_.string() : path_.string() + ".partial-" + std::to_string(::getpid());
  file_ = std::fopen(partial_.c_str(), "wb");
  if (file_ == nullptr) fail("a folder that can be written");
}

AtomicFile::~AtomicFile() {
  if (file_ != nullptr) discard();
}

void AtomicFile::write(std::string_view bytes) {
  require(file_ != nullptr, "AtomicFile: written after commit");
  if (std::fwrite(bytes.data(), 1, bytes.size(), file_) != bytes.size()) fail("room on the disk");
}

void AtomicFile::commit() {
  require(file_ != nullptr, "AtomicFile: committed twice");
  if (std::fflush(file_) != 0) fail("room on the disk");
  // Pipes, devices and some file systems cannot be synced.
  if (::fsync(::fileno(file_)) != 0 && errno != EINVAL && errno != EROFS) fail("room on the disk");
  if (std::fclose(std::exchange(file_, nullptr)) != 0) fail("room on the disk");
  if (is_special_) return;
  std::error_code error;
  std::filesystem::rename(partial_, path_, error);
  if (error) {
    errno = error.value();
    fail("a place that can be written");
  }
}

void AtomicFile::discard() {
  if (file_ != nullptr) std::fclose(std::exchange(file_, nullptr));
  if (is_special_) return;
  std::error_code ignored;
  std::filesystem::remove(partial_, ignored);
}

void AtomicFile::fail(const char* what) {
  const int reason = errno;
  discard();
  fail_to_write(path_, what, reason);
}

void write_file_atomically(const std::filesystem::path& path, std::string_view bytes) {
  AtomicFile file(path);
  file.write(bytes);
  file.commit();
}

}  // namespace palpate

#include "core/base/atomic_file.h"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

#include "core/base/error.h"

namespace palpate {

AtomicFile::AtomicFile(std::filesystem::path path) : path_(std::move(path)) {
  partial_ = path_.string() + ".partial-" + std::to_string(::getpid());
  file_ = std::fopen(partial_.c_str(), "wb");
  if (file_ == nullptr) fail("a folder that can be written");
}

AtomicFile::~AtomicFile() {
  if (file_ == nullptr) return;
  std::fclose(file_);
  std::error_code ignored;
  std::filesystem::remove(partial_, ignored);
}

void AtomicFile::write(std::string_view bytes) {
  require(file_ != nullptr, "AtomicFile: written after commit");
  if (std::fwrite(bytes.data(), 1, bytes.size(), file_) != bytes.size()) fail("room on the disk");
}

void AtomicFile::commit() {
  require(file_ != nullptr, "AtomicFile: committed twice");
  if (std::fflush(file_) != 0 || ::fsync(::fileno(file_)) != 0) {
    // Pipes and special files cannot be synced; anything else is a real failure.
    if (errno != EINVAL && errno != EROFS) fail("room on the disk");
  }
  if (std::fclose(std::exchange(file_, nullptr)) != 0) fail("room on the disk");
  std::error_code error;
  std::filesystem::rename(partial_, path_, error);
  if (error) {
    errno = error.value();
    fail("a place that can be written");
  }
}

void AtomicFile::fail(const char* what) {
  const std::string reason = std::strerror(errno);
  if (file_ != nullptr) std::fclose(std::exchange(file_, nullptr));
  std::error_code ignored;
  std::filesystem::remove(partial_, ignored);
  throw InputError(path_.string(), 0, what, reason);
}

void write_file_atomically(const std::filesystem::path& path, std::string_view bytes) {
  AtomicFile file(path);
  file.write(bytes);
  file.commit();
}

}  // namespace palpate

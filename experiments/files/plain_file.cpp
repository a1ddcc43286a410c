#include "experiments/files/plain_file.h"

#include <sys/stat.h>

#include <fstream>
#include <system_error>

#include "core/base/plain_file.h"

namespace palpate::experiments {

std::string file_complaint(const std::filesystem::path& path, std::uint64_t most) {
  struct stat status {};
  if (::lstat(path.c_str(), &status) != 0) return "none";
  std::string kind = file_kind(status.st_mode);
  if (kind.empty() && status.st_nlink > 1) return "a file that has another name too";
  if (!kind.empty() || static_cast<std::uint64_t>(status.st_size) <= most) return kind;
  return "a file of " + std::to_string(status.st_size) + " bytes, where " + std::to_string(most) +
         " are the most";
}

bool is_plain_file(const std::filesystem::path& path) {
  struct stat status {};
  return ::lstat(path.c_str(), &status) == 0 && S_ISREG(status.st_mode);
}

std::optional<std::string> read_bytes(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return std::nullopt;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  std::ifstream file(path, std::ios::binary);
  if (!file || error) return std::nullopt;
  std::string bytes(size, '\0');
  file.read(bytes.data(), static_cast<std::streamsize>(size));
  if (static_cast<std::uintmax_t>(file.gcount()) != size) return std::nullopt;  // never a part for the whole
  return bytes;
}

FolderIdentity::FolderIdentity(const std::filesystem::path& folder) : folder_(folder) {
  struct stat status {};
  if (::lstat(folder_.c_str(), &status) != 0 || !S_ISDIR(status.st_mode)) return;
  device_ = status.st_dev;
  number_ = status.st_ino;
}

bool FolderIdentity::is_same() const {
  struct stat status {};
  return ::lstat(folder_.c_str(), &status) == 0 && S_ISDIR(status.st_mode) && status.st_dev == device_ &&
         status.st_ino == number_;
}

}  // namespace palpate::experiments

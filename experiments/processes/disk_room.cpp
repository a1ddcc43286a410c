#include "experiments/processes/disk_room.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <system_error>

#include "experiments/files/plain_file.h"

namespace palpate::experiments {
namespace {

namespace fs = std::filesystem;

bool says_full(std::string_view said) {
  constexpr std::array<std::string_view, 2> kWords{"No space left on device", "Disk quota exceeded"};
  return std::any_of(kWords.begin(), kWords.end(),
                     [said](std::string_view words) { return said.find(words) != std::string_view::npos; });
}

/// Whether the system has no room at a place for who has said so: bytes, or numbers of files.
bool is_full(const fs::path& folder, std::uint64_t least_room) {
  struct statvfs disk {};
  if (::statvfs(folder.c_str(), &disk) != 0 || disk.f_blocks == 0) return false;
  constexpr fsfilcnt_t kLeastFiles = 16;
  return static_cast<std::uint64_t>(disk.f_bavail) * disk.f_frsize < least_room ||
         (disk.f_files > 0 && disk.f_favail < kLeastFiles);
}

/// Whether a file of kLeastRoom can't be written below the folder: a quota leaves the disk itself room.
bool refuses_file(const fs::path& folder) {
  std::string name = (folder / "palpate-room-XXXXXX").string();
  const int file = ::mkostemp(name.data(), O_CLOEXEC);
  if (file < 0) return errno == EDQUOT || errno == ENOSPC;
  ::unlink(name.c_str());
  const int error = ::posix_fallocate(file, 0, static_cast<off_t>(kLeastRoom));
  ::close(file);
  return error == EDQUOT || error == ENOSPC;
}

/// What the files below a folder take of the disk, up to `most`: a file with holes takes less than its size.
std::uint64_t bytes_below(const fs::path& folder, std::uint64_t most) {
  constexpr std::uint64_t kBlock = 512;  // of st_blocks
  std::uint64_t bytes = 0;
  std::error_code error;
  auto at = fs::recursive_directory_iterator(folder, fs::directory_options::skip_permission_denied, error);
  for (; !error && at != fs::end(at) && bytes <= most; at.increment(error)) {
    struct stat status {};
    if (::lstat(at->path().c_str(), &status) == 0)
      bytes += kBlock * static_cast<std::uint64_t>(status.st_blocks);
  }
  return bytes;
}

}  // namespace

std::string room_complaint(const fs::path& folder, std::string_view said) {
  if (bytes_below(folder, kLargestOutput) > kLargestOutput) return "";
  const auto complain = [](const fs::path& place) {
    struct statvfs disk {};
    ::statvfs(place.c_str(), &disk);
    const std::uint64_t left = static_cast<std::uint64_t>(disk.f_bavail) * disk.f_frsize;
    return place.string() + ": expected room on the disk, found " + std::to_string(left >> 20U) +
           " MiB left" + (disk.f_files > 0 ? " for " + std::to_string(disk.f_favail) + " files" : "");
  };
  if (is_full(folder, kLeastRoom)) return complain(folder);
  if (!says_full(said)) return "";
  if (is_full(folder, kLargestOutput) || refuses_file(folder)) return complain(folder);
  std::error_code error;
  const fs::path temporary = fs::temp_directory_path(error);
  if (!error && (is_full(temporary, kLeastRoom) || refuses_file(temporary))) return complain(temporary);
  return "";
}

}  // namespace palpate::experiments

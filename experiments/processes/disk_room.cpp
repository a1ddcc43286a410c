#include "experiments/processes/disk_room.h"

#include <sys/stat.h>
#include <sys/statvfs.h>

#include <algorithm>
#include <array>
#include <cstdint>
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
  struct statvfs disk {};
  if (::statvfs(folder.c_str(), &disk) != 0 || disk.f_blocks == 0) return "";
  const std::uint64_t left = static_cast<std::uint64_t>(disk.f_bavail) * disk.f_frsize;
  const bool may_be = left < kLeastRoom || (left < kLargestOutput && says_full(said));
  if (!may_be || bytes_below(folder, kLargestOutput) > kLargestOutput) return "";
  return folder.string() + ": expected room on the disk, found " + std::to_string(left >> 20U) + " MiB left";
}

}  // namespace palpate::experiments

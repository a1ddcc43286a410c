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
#include <optional>
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

/// What a disk has left.
struct Room {
  std::uint64_t bytes = 0;
  std::optional<std::uint64_t> files;  ///< unless it does not count them

  bool is_short(std::uint64_t least_bytes) const {
    constexpr std::uint64_t kLeastFiles = 16;
    return bytes < least_bytes || (files && *files < kLeastFiles);
  }
};

/// That of the disk on which a folder is; nothing where the system does not say.
std::optional<Room> room_at(const fs::path& folder) {
  struct statvfs disk {};
  if (::statvfs(folder.c_str(), &disk) != 0 || disk.f_blocks == 0) return std::nullopt;
  Room room;
  room.bytes = static_cast<std::uint64_t>(disk.f_bavail) * disk.f_frsize;
  if (disk.f_files > 0) room.files = disk.f_favail;
  return room;
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

/// Says so if less than this is left where a folder is, or `said` is true and a quota refuses a file.
std::string shortage(const fs::path& folder, std::uint64_t least_bytes, bool said) {
  const auto room = room_at(folder);
  if (!room || !(room->is_short(least_bytes) || (said && refuses_file(folder)))) return "";
  return folder.string() + ": expected room on the disk, found " + std::to_string(room->bytes >> 20U) +
         " MiB left" + (room->files ? " for " + std::to_string(*room->files) + " files" : "");
}

}  // namespace

std::string room_complaint(const fs::path& folder, std::string_view said) {
  const bool is_said = says_full(said);
  std::string complaint = shortage(folder, is_said ? kLargestFile : kLeastRoom, is_said);
  std::error_code error;
  const fs::path temporary = fs::temp_directory_path(error);
  if (complaint.empty() && is_said && !error) complaint = shortage(temporary, kLeastRoom, true);
  if (complaint.empty() || bytes_below(folder, kLargestFile) > kLargestFile) return "";
  return complaint;
}

}  // namespace palpate::experiments

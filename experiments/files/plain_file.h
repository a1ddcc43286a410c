// Files that somebody else left: what they may be, and their bytes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace palpate::experiments {

/// The largest file that is hashed, copied into a run or handed to a vendor's reader, and the largest that a
/// contestant may write: one with holes claims any size.
inline constexpr std::uint64_t kLargestFile = std::uint64_t{4} << 30U;

/// What keeps a path from being a regular file of at most `most` bytes, in words: "a link", "a folder", "a
/// pipe", "a device", "a socket", "a file that has another name too" (a hard link: to what, nobody can tell),
/// "a file of 53687091200 bytes, where 4294967296 are the most"; empty if nothing does. A path that is not
/// there is "none". Links are not followed, whatever they lead to.
std::string file_complaint(const std::filesystem::path& path, std::uint64_t most = kLargestFile);

/// Whether the path is a regular file, and no link to one.
bool is_plain_file(const std::filesystem::path& path);

/// The bytes of a regular file, all of them; nothing if there is none or it cannot be read whole.
std::optional<std::string> read_bytes(const std::filesystem::path& path);

/// A folder as it was, to tell whether it has been replaced by another one or by a link.
class FolderIdentity {
 public:
  explicit FolderIdentity(const std::filesystem::path& folder);
  bool is_same() const;

 private:
  std::filesystem::path folder_;
  std::uint64_t device_ = 0;
  std::uint64_t number_ = 0;
};

}  // namespace palpate::experiments

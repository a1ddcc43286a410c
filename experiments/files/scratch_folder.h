// A folder for files between programs.
#pragma once

#include <filesystem>
#include <string>

namespace palpate::experiments {

/// A private folder below the system's temporary one; removed at the end, or, if the program was stopped
/// before its end, by a later one of the same user.
class ScratchFolder {
 public:
  /// Throws: UnavailableError if it cannot be made.
  ScratchFolder();
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path file(const std::string& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
  int lock_ = -1;  ///< held on the folder as long as it is in use
};

}  // namespace palpate::experiments

// A folder for files between programs.
#pragma once

#include <filesystem>
#include <string>

namespace palpate::experiments {

/// A private folder below the system's temporary one; removed at the end.
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
};

}  // namespace palpate::experiments

// What this process flushes to the disk, in order.
#pragma once

#include <filesystem>
#include <vector>

namespace palpate::test {

/// Notes what is flushed (fsync) as long as it lives. One at a time.
class SyncedFiles {
 public:
  SyncedFiles();
  ~SyncedFiles();
  SyncedFiles(const SyncedFiles&) = delete;
  SyncedFiles& operator=(const SyncedFiles&) = delete;

  std::vector<std::filesystem::path> paths() const;
};

}  // namespace palpate::test

// Files that are either whole or absent.
#pragma once

#include <cstdio>
#include <filesystem>
#include <string>
#include <string_view>

namespace palpate {

/// Writes a file beside its final place and renames it on commit(); without a commit nothing is left behind.
/// Links are followed. A pipe or a device is written straight: it is never replaced by a file.
/// Throws: InputError from every member when the folder cannot be written or the disk is full.
class AtomicFile {
 public:
  explicit AtomicFile(std::filesystem::path path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  void write(std::string_view bytes);

  /// Flushes to the disk, closes and renames. Nothing can be written afterwards.
  void commit();

 private:
  [[noreturn]] void fail(const char* what);
  void discard();

  std::filesystem::path path_;
  std::filesystem::path partial_;
  std::FILE* file_ = nullptr;
  bool is_special_ = false;
};

/// Writes a whole file at once.
void write_file_atomically(const std::filesystem::path& path, std::string_view bytes);

}  // namespace palpate

// Files that are either whole or absent.
#pragma once

#include <cstdio>
#include <filesystem>
#include <string>
#include <string_view>

#include "core/base/error.h"

namespace palpate {

/// A file cannot be written because the disk is full, or a quota is used up. No input is to blame: exit
/// code 3.
class NoRoomError : public InputError {
 public:
  using InputError::InputError;
};

/// Throws NoRoomError if `reason` (an errno) says that there is no room, otherwise InputError: "`path`:
/// expected `expected`, found" the system's words for it.
[[noreturn]] void fail_to_write(const std::filesystem::path& path, const std::string& expected, int reason);

/// Writes a file beside its final place and renames it on commit(); without a commit nothing is left behind.
/// Links are followed. A pipe or a device is written straight: it is never replaced by a file.
/// Throws: InputError from every member when the folder cannot be written, NoRoomError when the disk is full.
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

// What stands at a path before anything of it is read: a pipe would be waited for, a device may have no end.
// And files that have to be there, and whole, after a power cut.
#pragma once

#include <sys/stat.h>

#include <filesystem>
#include <functional>
#include <string>

namespace palpate {

/// "a link", "a folder", "a pipe", "a socket", "a device"; empty for a file. `mode` is the system's.
const char* file_kind(mode_t mode);

/// Throws: InputError, "`path`: expected `expected`, found a pipe", if there is something at the path, at the
///         end of links too, and it is no file. What is not there is left to who opens it.
void refuse_no_file(const std::filesystem::path& path, const std::string& expected);

/// Behind the name of a file that is being written, as AtomicFile does it: this, and the number of the
/// process.
inline constexpr const char* kPartialMark = ".partial-";

/// Flushes a file and its folder to the disk: who reads after a power cut finds it there, and whole. What
/// cannot be flushed (some file systems) is left.
/// Throws: InputError if there is no such file, NoRoomError when the disk is full.
void sync_to_disk(const std::filesystem::path& path);

/// Copies a file. The copy gets its name when it is whole, lies on the disk, and `check` has looked at it,
/// which may throw. Throws: InputError if it cannot be written, NoRoomError when the disk is full.
void copy_file_atomically(const std::filesystem::path& from, const std::filesystem::path& to,
                          const std::function<void(const std::filesystem::path& copy)>& check);

}  // namespace palpate

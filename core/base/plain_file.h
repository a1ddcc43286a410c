// What stands at a path before anything of it is read: a pipe would be waited for, a device may have no end.
#pragma once

#include <sys/stat.h>

#include <filesystem>
#include <string>

namespace palpate {

/// "a link", "a folder", "a pipe", "a socket", "a device"; empty for a file. `mode` is the system's.
const char* file_kind(mode_t mode);

/// Throws: InputError, "`path`: expected `expected`, found a pipe", if there is something at the path, at the
///         end of links too, and it is no file. What is not there is left to who opens it.
void refuse_no_file(const std::filesystem::path& path, const std::string& expected);

}  // namespace palpate

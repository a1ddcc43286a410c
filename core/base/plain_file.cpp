#include "core/base/plain_file.h"

#include "core/base/error.h"

namespace palpate {

const char* file_kind(mode_t mode) {
  if (S_ISLNK(mode)) return "a link";
  if (S_ISDIR(mode)) return "a folder";
  if (S_ISFIFO(mode)) return "a pipe";
  if (S_ISSOCK(mode)) return "a socket";
  return S_ISREG(mode) ? "" : "a device";
}

void refuse_no_file(const std::filesystem::path& path, const std::string& expected) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0 || S_ISREG(status.st_mode)) return;
  throw InputError(path.string(), 0, expected, file_kind(status.st_mode));
}

}  // namespace palpate

#include "experiments/files/remove_tree.h"

#include <dirent.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <string>
#include <vector>

namespace palpate::experiments {
namespace {

constexpr int kMostDepth = 32;  // open files at a time; what lies deeper is moved up first

/// A folder that is open as long as this lives.
class OpenFolder {
 public:
  OpenFolder(int parent, const char* name)
      : file_(::openat(parent, name, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC)) {}
  ~OpenFolder() {
    if (file_ >= 0) ::close(file_);
  }
  OpenFolder(const OpenFolder&) = delete;
  OpenFolder& operator=(const OpenFolder&) = delete;

  int file() const { return file_; }

  std::vector<std::string> names() const {
    std::vector<std::string> names;
    const int again = ::openat(file_, ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    DIR* const stream = again >= 0 ? ::fdopendir(again) : nullptr;
    if (stream == nullptr) {
      if (again >= 0) ::close(again);
      return names;
    }
    while (const dirent* const entry = ::readdir(stream)) {
      const std::string name = entry->d_name;
      if (name != "." && name != "..") names.push_back(name);
    }
    ::closedir(stream);
    return names;
  }

 private:
  int file_;
};

class Emptying {
 public:
  explicit Emptying(const OpenFolder& top) : top_(top) {}

  /// Until nothing goes any more: what was moved up is there to be removed the next time.
  void run() {
    do {
      removed_ = false;
      for (const std::string& name : top_.names()) remove(top_.file(), name, 1);
    } while (removed_);
  }

 private:
  void remove(int parent, const std::string& name, int depth) {
    struct stat facts {};
    if (::fstatat(parent, name.c_str(), &facts, AT_SYMLINK_NOFOLLOW) != 0) return;
    if (!S_ISDIR(facts.st_mode)) {
      removed_ = ::unlinkat(parent, name.c_str(), 0) == 0 || removed_;
      return;
    }
    ::fchmodat(parent, name.c_str(), S_IRWXU, 0);
    if (depth >= kMostDepth) {
      const std::string place = ".deep-" + std::to_string(moved_++);
      removed_ = ::renameat(parent, name.c_str(), top_.file(), place.c_str()) == 0 || removed_;
      return;
    }
    {
      const OpenFolder folder(parent, name.c_str());
      if (folder.file() < 0) return;
      for (const std::string& below : folder.names()) remove(folder.file(), below, depth + 1);
    }
    removed_ = ::unlinkat(parent, name.c_str(), AT_REMOVEDIR) == 0 || removed_;
  }

  const OpenFolder& top_;
  bool removed_ = false;
  std::size_t moved_ = 0;
};

}  // namespace

void empty_folder(const std::filesystem::path& folder) {
  const OpenFolder top(AT_FDCWD, folder.c_str());
  if (top.file() >= 0) Emptying(top).run();
}

void remove_folder(const std::filesystem::path& folder) {
  empty_folder(folder);
  ::rmdir(folder.c_str());
}

}  // namespace palpate::experiments

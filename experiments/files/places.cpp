#include "experiments/files/places.h"

#include <cstdlib>

#include "core/base/error.h"

namespace palpate::experiments {
namespace {

namespace fs = std::filesystem;

std::optional<fs::path> find_prefix() {
  std::error_code error;
  const fs::path folder = fs::read_symlink("/proc/self/exe", error).parent_path();
  if (error || folder.filename() != "palpate" || folder.parent_path().filename() != "lib")
    return std::nullopt;
  fs::path prefix = folder.parent_path().parent_path();
  if (!fs::is_directory(prefix / "share" / "palpate" / "experiments", error)) return std::nullopt;
  return prefix;
}

/// A folder below PREFIX, or the one that was baked in.
std::string installed_or_built(const char* below_prefix, const char* built) {
  return install_prefix() ? (*install_prefix() / below_prefix / "palpate").string() : built;
}

/// The absolute path that an environment variable holds; none if it holds no such.
std::optional<fs::path> folder_in(const char* variable) {
  const char* value = std::getenv(variable);
  if (value == nullptr || *value != '/') return std::nullopt;
  return fs::path(value);
}

}  // namespace

const std::optional<fs::path>& install_prefix() {
  static const std::optional<fs::path> prefix = find_prefix();
  return prefix;
}

const std::string& source_folder() {
  static const std::string folder = installed_or_built("share", PALPATE_SOURCE_DIR);
  return folder;
}

const std::string& program_folder() {
  static const std::string folder = installed_or_built("lib", PALPATE_BIN_DIR);
  return folder;
}

fs::path page_folder() {
  return (install_prefix() ? fs::path(source_folder()) : fs::path(program_folder()).parent_path()) / "page";
}

fs::path results_root() {
  return (install_prefix() ? fs::current_path() : fs::path(source_folder())) / "results";
}

fs::path default_cache_root() {
  if (!install_prefix()) return fs::path(program_folder()).parent_path();
  if (const auto folder = folder_in("XDG_CACHE_HOME")) return *folder / "palpate";
  if (const auto folder = folder_in("HOME")) return *folder / ".cache" / "palpate";
  throw InputError(
      "no folder for meshes and answers that are kept: expected PALPATE_CACHE, XDG_CACHE_HOME or HOME to "
      "name one, "
      "found none");
}

}  // namespace palpate::experiments

#include "experiments/records/source_version.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <vector>

#include "core/base/error.h"
#include "experiments/files/places.h"
#include "experiments/processes/program_output.h"
#include "experiments/text/yaml_value.h"

namespace palpate::experiments {
namespace {

constexpr std::size_t kCommitDigits = 9;

/// What git says of the folder, without the last line's end; empty if it fails.
std::string ask_git(const std::string& folder, std::vector<std::string> words) {
  // Without locks: one that is killed while it refreshes the index would leave a lock in the checkout.
  words.insert(words.begin(), {"/usr/bin/git", "--no-optional-locks", "-C", folder});
  std::string text = program_output(words);
  while (!text.empty() && text.back() == '\n') text.pop_back();
  return text;
}

bool is_own_checkout(const std::string& folder) {
  const std::string top = ask_git(folder, {"rev-parse", "--show-toplevel"});
  std::error_code error;
  return !top.empty() && std::filesystem::equivalent(top, folder, error);
}

bool is_commit(const std::string& text) {
  return text.size() >= kCommitDigits &&
         std::all_of(text.begin(), text.end(), [](unsigned char c) { return std::isxdigit(c) != 0; });
}

/// What the file says. Unknown where git has not filled it in, or where it cannot be read: a run does not
/// fail for want of it.
SourceVersion read_version(const std::filesystem::path& file) {
  SourceVersion version;
  try {
    const YamlFields fields = read_yaml(file).fields({"commit", "source", "dirty"});
    const std::string commit = fields.need("commit").text();
    if (!is_commit(commit)) return version;
    version.commit = commit.substr(0, kCommitDigits);
    version.source = fields.need("source").text();
    if (const auto dirty = fields.find("dirty")) version.dirty = dirty->boolean();
  } catch (const InputError&) {
    version = {};
  }
  return version;
}

}  // namespace

SourceVersion find_source_version(const std::string& folder) {
  const std::string commit =
      is_own_checkout(folder) ? ask_git(folder, {"rev-parse", "--short=9", "HEAD"}) : "";
  if (commit.empty())
    return read_version(std::filesystem::path(folder) / "experiments/records/source_version.yaml");
  return {commit, "checkout", !ask_git(folder, {"status", "--porcelain", "--untracked-files=no"}).empty()};
}

SourceVersion find_source_version() {
  return find_source_version(source_folder());
}

}  // namespace palpate::experiments

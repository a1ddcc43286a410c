// Which sources this program was made from.
#pragma once

#include <optional>
#include <string>

namespace palpate::experiments {

/// The commit, abbreviated to 9 digits ("unknown" if nobody can tell), who says so, and whether files differ
/// from it.
struct SourceVersion {
  std::string commit = "unknown";
  /// "checkout" (git, asked now), "archive" (a source archive), "package" (an installed program) or
  /// "unknown".
  std::string source = "unknown";
  std::optional<bool> dirty;  ///< none if nobody can tell: nothing in an archive says what was changed since
};

/// Asks git where the sources are a checkout of their own (not a folder in somebody else's), else reads what
/// `git archive` or the package's build left in records/source_version.yaml.
SourceVersion find_source_version();

/// As find_source_version, of the sources at `folder`.
SourceVersion find_source_version(const std::string& folder);

}  // namespace palpate::experiments

// Folders that somebody else left, removed however deep they are.
#pragma once

#include <filesystem>

namespace palpate::experiments {

/// Removes what is in a folder, as far as that can be done: folders that nobody may write included, and those
/// that lie deeper within one another than a process may have files open. No link is followed. What there is
/// not is no error.
void empty_folder(const std::filesystem::path& folder);

/// The same, and the folder itself.
void remove_folder(const std::filesystem::path& folder);

}  // namespace palpate::experiments

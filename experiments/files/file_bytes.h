// A file's bytes, all at once.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace palpate::experiments {

/// The bytes of a regular file; nothing if there is none or it cannot be read.
std::optional<std::string> read_bytes(const std::filesystem::path& path);

}  // namespace palpate::experiments

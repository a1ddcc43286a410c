// Records of failed repeats, set aside so that the repeats are run anew.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>

namespace palpate::experiments {

/// Whether a repeat gave nothing that could be judged: any outcome but "accepted" and "rejected".
bool is_failure(const nlohmann::json& record);

/// Takes the records that `is_taken` out of `records` and appends them to `aside`. Whole at any moment: they
/// are on the disk in `aside` before `records` is replaced, so that a kill in between leaves them in both.
/// Returns: how many. Throws: InputError if a file cannot be read or written, NoRoomError on a full disk.
std::size_t set_aside(const std::filesystem::path& records, const std::filesystem::path& aside,
                      const std::function<bool(const nlohmann::json&)>& is_taken);

}  // namespace palpate::experiments

// Room on the disk: whether a failure may be for the want of it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace palpate::experiments {

/// Below it nothing that failed is blamed on who failed.
inline constexpr std::uint64_t kLeastRoom = std::uint64_t{16} << 20U;

/// Why something that failed, and wrote below `folder`, may have failed because the disk had no room; empty
/// if it can't have. It may where less than kLeastRoom is left, or where `said` (its message, what it wrote)
/// has the system's words for a full disk and less than kLargestFile or no number for a file is left, a
/// quota refuses a file of kLeastRoom, or the folder of temporary files has so little room: who says so on
/// disks with room is not believed. Who took more than kLargestFile by itself has filled the disk, and is
/// to blame.
std::string room_complaint(const std::filesystem::path& folder, std::string_view said);

}  // namespace palpate::experiments

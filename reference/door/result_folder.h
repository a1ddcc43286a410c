// The folder that a simulation leaves: what may be in it, and how an earlier one is taken away.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace palpate::reference {

/// "frame_00012.vtu": five digits or more.
std::string frame_name(std::size_t number);

/// What simulate has written into a folder: history.csv, frames.pvd, frame_00000.vtu and its like,
/// summary.json, displacement.csv and displacement.vtu.
/// Throws: InputError if a file of such a name does not look as simulate writes it: it is someone else's.
std::vector<std::filesystem::path> earlier_results(const std::filesystem::path& folder);

/// Removes earlier_results(folder), and nothing else. Throws: as it, and InputError if one cannot be removed.
void remove_earlier_results(const std::filesystem::path& folder);

}  // namespace palpate::reference

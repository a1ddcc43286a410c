// Checks of an output file before any work is done for it; folders for outputs.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace palpate::experiments {

/// Throws: InputError unless the file's ending is one that write_mesh knows and its folder can be written.
void check_output_file(const std::filesystem::path& path);

/// Throws: InputError unless the file's ending is .csv and its folder can be written.
void check_output_csv(const std::filesystem::path& path);

/// Throws: InputError unless the file's ending is .yaml or .yml and its folder can be written.
void check_output_yaml(const std::filesystem::path& path);

/// Whether two paths lead to one file, through links of either kind too, or would if it were there.
bool is_same_file(const std::filesystem::path& one, const std::filesystem::path& other);

/// Throws: InputError "`flag`: expected a file that is not the input, ..." if `out`, by whatever name, is one
///         of the inputs. Empty paths are none.
void refuse_output_over_input(const std::string& flag, const std::filesystem::path& out,
                              const std::vector<std::filesystem::path>& inputs);

/// Makes the folder and those above it, where they are missing. Throws: InputError if it cannot.
void create_folder(const std::filesystem::path& folder);

}  // namespace palpate::experiments

// Checks of an output file before any work is done for it; folders for outputs.
#pragma once

#include <filesystem>

namespace palpate::experiments {

/// Throws: InputError unless the file's ending is one that write_mesh knows and its folder can be written.
void check_output_file(const std::filesystem::path& path);

/// Throws: InputError unless the file's ending is .csv and its folder can be written.
void check_output_csv(const std::filesystem::path& path);

/// Throws: InputError unless the file's ending is .yaml or .yml and its folder can be written.
void check_output_yaml(const std::filesystem::path& path);

/// Makes the folder and those above it, where they are missing. Throws: InputError if it cannot.
void create_folder(const std::filesystem::path& folder);

}  // namespace palpate::experiments

// What a folder says of its contestant: contestant.yaml.
#pragma once

#include <filesystem>
#include <vector>

#include "experiments/registry/contestant.h"

namespace palpate::experiments {

/// Reads contestant.yaml (palpate/contestant/1). Returns one entry for each contest that it lists.
/// Throws: InputError with file and line.
std::vector<Contestant> read_description(const std::filesystem::path& description,
                                         const std::filesystem::path& bin_folder);

}  // namespace palpate::experiments

// Hashes that tell whether two files are the same. Not a protection against an adversary.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace palpate::experiments {

/// XXH3, 128 bits, in hexadecimal, with its name in front: "xxh3:0123...". The same on every machine.
std::string hash_bytes(std::string_view bytes);

/// Hash of a file's bytes, read in pieces. Throws: InputError if it cannot be read, or has more than
/// kLargestFile.
std::string hash_file(const std::filesystem::path& path);

}  // namespace palpate::experiments

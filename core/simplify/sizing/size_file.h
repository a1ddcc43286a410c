// Wanted sizes as a file: what a simplifier is handed, whoever chose them.
#pragma once

#include <filesystem>
#include <span>
#include <vector>

namespace palpate::simplify {

/// Reads one wanted edge length a vertex: CSV with the header "vertex,size", the vertices in order from 0.
/// Only ratios mean anything, as the count decides how long edges are.
/// Throws: InputError "file:line: ..." for another header, a row out of order, a number that is not finite or
/// not above 0, or another number of rows than `vertices`.
std::vector<double> read_sizes(const std::filesystem::path& path, std::size_t vertices);

/// Writes them so that they read back to the same bits. Throws: InputError if the file cannot be written.
void write_sizes(const std::filesystem::path& path, std::span<const double> sizes);

}  // namespace palpate::simplify

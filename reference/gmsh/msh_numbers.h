// What gmsh does not say when it reads a file: that two nodes or two elements have one number.
#pragma once

#include <filesystem>

namespace palpate::reference {

/// Reads the numbers of nodes and elements of a .msh file (versions 1, 2 and 4, ASCII or binary) and refuses
/// one that is there twice: gmsh keeps one of the two, and drops the other without a word.
/// Time and memory: linear in the file. What is no .msh file, or is broken, is left to gmsh.
/// Throws: InputError with the number, and in an ASCII file the two lines.
void check_numbers_differ(const std::filesystem::path& path);

}  // namespace palpate::reference

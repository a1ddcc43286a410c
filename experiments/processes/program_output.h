// What programs say of themselves or of others, in short: git of sources, the dynamic loader of a program.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace palpate::experiments {

/// What a program (its path and arguments) prints; empty if it cannot be run, fails, or takes 20 s.
std::string program_output(const std::vector<std::string>& arguments);

/// The first shared library that an installed program of ours does not find; empty if it finds all, and for
/// any program that was not installed: what is in a build folder was linked on this machine. A package only
/// recommends the libraries of some contestants.
std::string missing_library(const std::filesystem::path& program);

}  // namespace palpate::experiments

// Whether a program finds the shared libraries that it was linked with.
#pragma once

#include <filesystem>
#include <string>

namespace palpate::experiments {

/// The first shared library that an installed program of ours does not find; empty if it finds all, and for any program that was not
/// installed: what is in a build folder was linked on this machine. A package only recommends the libraries of some contestants.
std::string missing_library(const std::filesystem::path& program);

}  // namespace palpate::experiments

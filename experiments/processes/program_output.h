// What a small program says, such as git.
#pragma once

#include <string>
#include <vector>

namespace palpate::experiments {

/// What a program (its path and arguments) prints; empty if it cannot be run, fails, or takes 20 s.
std::string program_output(const std::vector<std::string>& arguments);

}  // namespace palpate::experiments

// The scripts of report/, as processes.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "experiments/processes/process.h"

namespace palpate::experiments {

/// What starts a script of report/ ("make_report.py") by the system's Python. Where its output goes is left
/// to set. Throws: UnavailableError if the script is missing.
ProcessSpec report_script(const std::string& name, const std::vector<std::string>& arguments);

/// The same for a script that writes a page: it is told where this build left the page's scripts.
ProcessSpec page_script(const std::string& name, std::vector<std::string> arguments);

/// The last line that a script wrote into a file; empty if there is none.
std::string last_line(const std::filesystem::path& file);

}  // namespace palpate::experiments

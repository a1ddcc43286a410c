// The scripts of report/, as processes.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "experiments/files/scratch_folder.h"
#include "experiments/processes/process.h"

namespace palpate::experiments {

/// What starts a script of report/ ("make_report.py") by the system's Python. Where its output goes is left
/// to set. Throws: UnavailableError if the script is missing.
ProcessSpec report_script(const std::string& name, const std::vector<std::string>& arguments);

/// The same for a script that writes a page: it is told where this build left the page's scripts.
ProcessSpec page_script(const std::string& name, std::vector<std::string> arguments);

/// How a script ended, and what it printed.
struct ScriptAnswer {
  int exit_code = 0;  ///< 0, 1, or 130 if the user stopped it
  std::string output;
};

/// Runs a script; its outputs go through files of `scratch`. `what` is what fails if it does ("the report").
/// Throws: InputError with its last line if it ended with 2; UnavailableError with it if it ended in any way
/// but with 0 or 1.
ScriptAnswer run_script(ProcessSpec spec, const ScratchFolder& scratch, const std::string& what);

/// The last line that a script wrote into a file; empty if there is none.
std::string last_line(const std::filesystem::path& file);

}  // namespace palpate::experiments

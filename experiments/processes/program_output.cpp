#include "experiments/processes/program_output.h"

#include <map>
#include <mutex>
#include <sstream>

#include "experiments/files/places.h"
#include "experiments/files/plain_file.h"
#include "experiments/files/scratch_folder.h"
#include "experiments/processes/process.h"

namespace palpate::experiments {
namespace {

/// Asks the dynamic loader, as ldd does: it prints "NAME => PATH" or "NAME => not found" a line and starts
/// nothing.
std::string ask_loader(const std::filesystem::path& program) {
  std::istringstream lines(program_output({"/usr/bin/env", "LD_TRACE_LOADED_OBJECTS=1", program.string()}));
  for (std::string line; std::getline(lines, line);) {
    const std::size_t arrow = line.find(" => not found");
    if (arrow == std::string::npos) continue;
    const std::size_t start = line.find_first_not_of(" \t");
    return line.substr(start, arrow - start);
  }
  return "";
}

}  // namespace

std::string program_output(const std::vector<std::string>& arguments) {
  const ScratchFolder scratch;
  ProcessSpec spec;
  spec.arguments = arguments;
  spec.timeout_s = 20.0;
  spec.standard_output = scratch.file("output");
  const ProcessResult result = run_process(spec);
  const std::string text = read_bytes(spec.standard_output).value_or("");
  return result.end == ProcessEnd::kExited && result.exit_code == 0 ? text : "";
}

std::string missing_library(const std::filesystem::path& program) {
  if (!install_prefix() || program.parent_path() != program_folder()) return "";
  static std::mutex mutex;
  static std::map<std::filesystem::path, std::string> known;
  const std::lock_guard<std::mutex> lock(mutex);
  const auto found = known.find(program);
  if (found != known.end()) return found->second;
  return known[program] = ask_loader(program);
}

}  // namespace palpate::experiments

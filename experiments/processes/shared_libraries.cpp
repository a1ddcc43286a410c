#include "experiments/processes/shared_libraries.h"

#include <map>
#include <mutex>
#include <sstream>

#include "experiments/files/file_bytes.h"
#include "experiments/files/installation.h"
#include "experiments/files/places.h"
#include "experiments/files/scratch_folder.h"
#include "experiments/processes/process.h"

namespace palpate::experiments {
namespace {

/// Asks the dynamic loader, as ldd does: it prints "NAME => PATH" or "NAME => not found" a line and starts nothing.
std::string ask_loader(const std::filesystem::path& program) {
  const ScratchFolder scratch;
  ProcessSpec spec;
  spec.arguments = {"/usr/bin/env", "LD_TRACE_LOADED_OBJECTS=1", program.string()};
  spec.timeout_s = 60.0;
  spec.standard_output = scratch.file("libraries");
  run_process(spec);
  std::istringstream lines(read_bytes(spec.standard_output).value_or(""));
  for (std::string line; std::getline(lines, line);) {
    const std::size_t arrow = line.find(" => not found");
    if (arrow == std::string::npos) continue;
    const std::size_t start = line.find_first_not_of(" \t");
    return line.substr(start, arrow - start);
  }
  return "";
}

}  // namespace

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

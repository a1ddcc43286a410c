#include "experiments/registry/contestant.h"

#include <unistd.h>

#include <algorithm>

#include "experiments/files/file_hash.h"
#include "experiments/processes/program_output.h"
#include "experiments/text/nearest_name.h"

namespace palpate::experiments {
namespace {

std::string not_built(const std::filesystem::path& program, const std::vector<std::string>& packages) {
  std::string why = "its program " + program.filename().string() + " was not built";
  if (!packages.empty()) why += " (needs " + joined(packages) + ")";
  return why;
}

std::string why_not_started(const std::filesystem::path& program) {
  const std::string library = missing_library(program);
  if (library.empty()) return "";
  return "its program " + program.filename().string() + " lacks the shared library " + library +
         ", of a package that palpate recommends";
}

}  // namespace

const OptionSpec* MethodSpec::find_option(const std::string& option) const {
  for (const OptionSpec& spec : options) {
    if (spec.name == option) return &spec;
  }
  return nullptr;
}

bool MethodSpec::takes_stop(const std::string& kind) const {
  return std::find(stops.begin(), stops.end(), kind) != stops.end();
}

std::string Contestant::unavailable() const {
  std::error_code error;
  if (std::filesystem::exists(program, error)) {
    const bool runs =
        std::filesystem::is_regular_file(program, error) && ::access(program.c_str(), X_OK) == 0;
    if (!runs) return "its program " + program.filename().string() + " is not executable";
    for (const std::filesystem::path& file : files) {
      if (!std::filesystem::is_regular_file(file, error)) return "its file " + file.string() + " is missing";
    }
    if (std::string why = why_not_started(program); !why.empty()) return why;
    for (const std::filesystem::path& other : starts) {
      if (!std::filesystem::exists(other, error)) return not_built(other, packages);
      if (std::string why = why_not_started(other); !why.empty()) return why;
    }
    return "";
  }
  if (program.is_relative()) return "its program " + program.string() + " is not in PATH";
  return not_built(program, packages);
}

std::string hash_contestant(const Contestant& contestant) {
  std::string all = hash_file(contestant.program);
  if (contestant.files.empty()) return all;
  for (const std::filesystem::path& file : contestant.files)
    all += "\n" + file.filename().string() + " " + hash_file(file);
  return hash_bytes(all);
}

}  // namespace palpate::experiments

#include "experiments/files/output_file.h"

#include <unistd.h>

#include "core/base/error.h"

namespace palpate::experiments {

namespace {

[[noreturn]] void refuse_ending(const std::filesystem::path& path, const std::string& expected) {
  const std::string ending = path.extension().string();
  throw InputError(path.string(), 0, "an output that ends in " + expected,
                   ending.empty() ? "no ending" : "\"" + ending + "\"");
}

void check_place(const std::filesystem::path& path) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) throw InputError(path.string(), 0, "a file", "a folder");
  const auto folder = path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
  if (!std::filesystem::is_directory(folder, error)) {
    throw InputError(path.string(), 0, "an output in a folder that exists", "no folder " + folder.string());
  }
  if (::access(folder.c_str(), W_OK) != 0) {
    throw InputError(path.string(), 0, "an output in a folder that can be written", folder.string());
  }
}

}  // namespace

void check_output_file(const std::filesystem::path& path) {
  if (path.extension() != ".mesh" && path.extension() != ".vtu") refuse_ending(path, ".mesh or .vtu");
  check_place(path);
}

void check_output_csv(const std::filesystem::path& path) {
  if (path.extension() != ".csv") refuse_ending(path, ".csv");
  check_place(path);
}

void check_output_yaml(const std::filesystem::path& path) {
  if (path.extension() != ".yaml" && path.extension() != ".yml") refuse_ending(path, ".yaml");
  check_place(path);
}

bool is_same_file(const std::filesystem::path& one, const std::filesystem::path& other) {
  std::error_code error;
  if (std::filesystem::equivalent(one, other, error)) return true;
  const auto place = [&error](const std::filesystem::path& path) {
    return std::filesystem::weakly_canonical(std::filesystem::absolute(path, error), error);
  };
  const std::filesystem::path first = place(one);
  return !first.empty() && first == place(other);
}

void refuse_output_over_input(const std::string& flag, const std::filesystem::path& out,
                              const std::vector<std::filesystem::path>& inputs) {
  for (const std::filesystem::path& input : inputs) {
    if (input.empty() || !is_same_file(out, input)) continue;
    throw InputError(flag, 0, "a file that is not the input",
                     out == input ? out.string() : out.string() + ", which is " + input.string());
  }
}

void create_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw InputError(folder.string(), 0, "a folder that can be written", error.message());
}

}  // namespace palpate::experiments

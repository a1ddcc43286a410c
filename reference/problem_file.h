// Reading the problem file of a request.
#pragma once

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/base/error.h"

namespace palpate::reference {

/// The JSON of a problem file, whatever it holds. Throws: InputError if it cannot be read, or is no JSON.
inline nlohmann::json read_problem_file(const std::filesystem::path& path) {
  std::ifstream file(path);
  if (!file) throw InputError(path.string(), 0, "a readable problem file", "none");
  nlohmann::json value = nlohmann::json::parse(file, nullptr, false);
  if (value.is_discarded()) throw InputError(path.string(), 0, "a JSON object", "something else");
  return value;
}

}  // namespace palpate::reference

#include "experiments/files/file_bytes.h"

#include <fstream>
#include <sstream>
#include <system_error>
#include <utility>

namespace palpate::experiments {
namespace fs = std::filesystem;

std::optional<std::string> read_bytes(const fs::path& path) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return std::nullopt;
  std::ifstream file(path, std::ios::binary);
  if (!file) return std::nullopt;
  std::ostringstream bytes;
  if (fs::file_size(path, error) > 0) bytes << file.rdbuf();  // of an empty file it would set the fail bit
  return file.bad() ? std::nullopt : std::optional(std::move(bytes).str());
}

}  // namespace palpate::experiments

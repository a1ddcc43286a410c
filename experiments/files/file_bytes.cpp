#include "experiments/files/file_bytes.h"

#include <fstream>
#include <system_error>

namespace palpate::experiments {
namespace fs = std::filesystem;

std::optional<std::string> read_bytes(const fs::path& path) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return std::nullopt;
  const std::uintmax_t size = fs::file_size(path, error);
  std::ifstream file(path, std::ios::binary);
  if (!file || error) return std::nullopt;
  std::string bytes(size, '\0');
  file.read(bytes.data(), static_cast<std::streamsize>(size));
  if (static_cast<std::uintmax_t>(file.gcount()) != size) return std::nullopt;  // never a part for the whole
  return bytes;
}

}  // namespace palpate::experiments

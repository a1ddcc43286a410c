#include "core/simplify/sizing/size_file.h"

#include <charconv>
#include <cmath>
#include <fstream>
#include <string>
#include <string_view>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/base/plain_file.h"

namespace palpate::simplify {
namespace {

constexpr const char* kSizeHeader = "vertex,size";

/// "12,0.5" with 12 as the vertex that is next.
bool parse_size(std::string_view line, std::size_t vertex, double& size) {
  const std::size_t comma = line.find(',');
  if (comma == std::string_view::npos) return false;
  std::size_t number = 0;
  const char* const middle = line.data() + comma;
  const auto [end, error] = std::from_chars(line.data(), middle, number);
  if (error != std::errc() || end != middle || number != vertex) return false;
  const char* const last = line.data() + line.size();
  const auto [stop, wrong] = std::from_chars(middle + 1, last, size);
  return wrong == std::errc() && stop == last && std::isfinite(size) && size > 0.0;
}

}  // namespace

std::vector<double> read_sizes(const std::filesystem::path& path, std::size_t vertices) {
  refuse_no_file(path, "a file of sizes");
  std::ifstream file(path);
  const std::string where = path.string();
  std::string line;
  if (!file || !std::getline(file, line)) throw InputError(where, 0, "a file of sizes", "none");
  if (line != kSizeHeader) throw InputError(where, 1, kSizeHeader, line.substr(0, 80));
  std::vector<double> sizes;
  sizes.reserve(vertices);
  while (std::getline(file, line)) {
    double size = 0.0;
    if (!parse_size(line, sizes.size(), size))
      throw InputError(where, sizes.size() + 2,
                       std::to_string(sizes.size()) + ",SIZE with a finite size above 0", line.substr(0, 80));
    if (sizes.size() == vertices) break;
    sizes.push_back(size);
  }
  if (sizes.size() != vertices || file)
    throw InputError(where, 0, std::to_string(vertices) + " rows, one a vertex of the mesh",
                     file ? "more" : std::to_string(sizes.size()));
  return sizes;
}

void write_sizes(const std::filesystem::path& path, std::span<const double> sizes) {
  std::string text = std::string(kSizeHeader) + "\n";
  for (std::size_t v = 0; v < sizes.size(); ++v) {
    append_number(text, v);
    text += ',';
    append_number(text, sizes[v]);
    text += '\n';
  }
  write_file_atomically(path, text);
}

}  // namespace palpate::simplify

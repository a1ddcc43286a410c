#include "reference/vtk/inrimage.h"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>
#include <string>

#include "core/base/error.h"

namespace palpate::reference {
namespace {

constexpr std::size_t kHeaderBlock = 256;  // headers are padded to a multiple of this

/// The KEY=value lines of the header, and where the voxels begin.
struct Header {
  std::map<std::string, std::string> values;
  std::size_t voxels_at = 0;
};

Header parse_header(const std::string& bytes, const std::string& where) {
  const std::size_t end = bytes.find("##}");
  if (bytes.rfind("#INRIMAGE-4#{", 0) != 0 || end == std::string::npos) {
    throw InputError(where, 0, "an Inrimage header", "something else");
  }
  Header header;
  header.voxels_at = (end + 3 + kHeaderBlock - 1) / kHeaderBlock * kHeaderBlock;
  std::istringstream lines(bytes.substr(0, end));
  for (std::string line; std::getline(lines, line);) {
    const std::size_t sign = line.find('=');
    if (sign != std::string::npos) header.values[line.substr(0, sign)] = line.substr(sign + 1);
  }
  return header;
}

template <typename Number>
Number number(const Header& header, const char* key, const std::string& where) {
  const auto found = header.values.find(key);
  const std::string text = found == header.values.end() ? "" : found->second;
  Number value{};
  const auto error = std::from_chars(text.data(), text.data() + text.size(), value).ec;
  if (error != std::errc{} || !(value > 0)) {
    throw InputError(where, 0, std::string("a positive ") + key, "\"" + text + "\"");
  }
  return value;
}

/// Marks the 6-connected region of voxels with in(voxel) around `seed`; returns its size.
template <typename In>
std::size_t flood(const std::array<int, 3>& size, std::size_t seed, std::vector<std::uint32_t>& region,
                  std::uint32_t name, In&& in) {
  const std::size_t row = static_cast<std::size_t>(size[0]);
  const std::size_t slice = row * static_cast<std::size_t>(size[1]);
  const std::size_t depth = static_cast<std::size_t>(size[2]);
  std::vector<std::size_t> todo{seed};
  region[seed] = name;
  std::size_t count = 0;
  const auto visit = [&](std::size_t voxel) {
    if (region[voxel] != 0 || !in(voxel)) return;
    region[voxel] = name;
    todo.push_back(voxel);
  };
  while (!todo.empty()) {
    const std::size_t v = todo.back();
    todo.pop_back();
    ++count;
    if (v % row > 0) visit(v - 1);
    if (v % row + 1 < row) visit(v + 1);
    if (v % slice >= row) visit(v - row);
    if (v % slice + row < slice) visit(v + row);
    if (v >= slice) visit(v - slice);
    if (v / slice + 1 < depth) visit(v + slice);
  }
  return count;
}

}  // namespace

LabelImage read_inrimage(const std::filesystem::path& path) {
  const std::string where = path.string();
  std::ifstream file(path, std::ios::binary);
  if (!file) throw InputError(where, 0, "a readable image", "none");
  const std::string bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  const Header header = parse_header(bytes, where);
  const auto value = [&](const char* key) {
    const auto found = header.values.find(key);
    return found == header.values.end() ? std::string() : found->second;
  };
  if (value("VDIM") != "1" || value("TYPE") != "unsigned fixed" || value("PIXSIZE") != "8 bits") {
    throw InputError(where, 0, "one unsigned byte a voxel", value("TYPE") + " " + value("PIXSIZE"));
  }
  LabelImage image;
  constexpr int kLargestSide = 4096;
  std::size_t voxels = 1;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::array<const char*, 3> sides{"XDIM", "YDIM", "ZDIM"};
    const std::array<const char*, 3> lengths{"VX", "VY", "VZ"};
    image.size[i] = number<int>(header, sides[i], where);
    image.spacing[i] = number<double>(header, lengths[i], where);
    if (image.size[i] > kLargestSide) throw InputError(where, 0, "sides up to 4096 voxels", "more");
    voxels *= static_cast<std::size_t>(image.size[i]);
  }
  if (bytes.size() < header.voxels_at + voxels) {
    throw InputError(where, 0, std::to_string(voxels) + " voxels", "a shorter file");
  }
  const auto first = bytes.begin() + static_cast<std::ptrdiff_t>(header.voxels_at);
  image.labels.assign(first, first + static_cast<std::ptrdiff_t>(voxels));
  return image;
}

std::vector<std::uint8_t> largest_component(const LabelImage& image, std::uint8_t label) {
  std::vector<std::uint32_t> region(image.labels.size(), 0);
  std::uint32_t name = 0;
  std::uint32_t largest = 0;
  std::size_t largest_count = 0;
  for (std::size_t v = 0; v < region.size(); ++v) {
    if (image.labels[v] != label || region[v] != 0) continue;
    const std::size_t count =
        flood(image.size, v, region, ++name, [&](std::size_t w) { return image.labels[w] == label; });
    if (count > largest_count) {
      largest = name;
      largest_count = count;
    }
  }
  if (largest == 0) throw InputError("label", 0, "voxels of label " + std::to_string(label), "none");
  std::vector<std::uint8_t> mask(region.size());
  for (std::size_t v = 0; v < region.size(); ++v) mask[v] = region[v] == largest ? 1 : 0;
  if (mask[0] != 0) throw InputError("image", 0, "a first voxel outside the organ", "one inside");
  std::fill(region.begin(), region.end(), 0);
  flood(image.size, 0, region, 1, [&](std::size_t w) { return mask[w] == 0; });
  for (std::size_t v = 0; v < region.size(); ++v) {
    if (region[v] == 0) mask[v] = 1;
  }
  return mask;
}

}  // namespace palpate::reference

// Built into a program with gmsh, GPL: this program is distributed under GPL-3.0-or-later.
#include "reference/gmsh/msh_numbers.h"

#include <array>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "core/base/error.h"

namespace palpate::reference {
namespace {

using Number = std::int64_t;

/// The numbers of one section, and the line each came from (0 in a binary file).
class Numbers {
 public:
  Numbers(std::string where, const char* kind) : where_(std::move(where)), kind_(kind) {}

  void add(Number number, std::size_t line) {
    const auto [entry, is_new] = line_of_.emplace(number, line);
    if (is_new) return;
    const std::string what = std::string(kind_) + " number " + std::to_string(number);
    const std::string found =
        line > 0 ? what + " on line " + std::to_string(entry->second) + " too" : what + " twice";
    throw InputError(where_, line, std::string(kind_) + "s with a number of their own", found);
  }

 private:
  std::string where_;
  const char* kind_;
  std::unordered_map<Number, std::size_t> line_of_;
};

/// The whole numbers at the start of a line, at most `most`.
std::vector<Number> leading_numbers(const std::string& line, std::size_t most) {
  std::vector<Number> numbers;
  const char* at = line.data();
  const char* const end = at + line.size();
  while (numbers.size() < most) {
    while (at < end && (*at == ' ' || *at == '\t')) ++at;
    Number number = 0;
    const auto [next, error] = std::from_chars(at, end, number);
    if (error != std::errc{}) break;
    numbers.push_back(number);
    at = next;
  }
  return numbers;
}

/// Lines with their numbers.
class Lines {
 public:
  explicit Lines(const std::filesystem::path& path) : file_(path, std::ios::binary) {}

  bool next(std::string& line) {
    if (!std::getline(file_, line)) return false;
    ++number_;
    if (!line.empty() && line.back() == '\r') line.pop_back();
    return true;
  }

  std::size_t number() const { return number_; }
  std::istream& bytes() { return file_; }

 private:
  std::ifstream file_;
  std::size_t number_ = 0;
};

/// What `$MeshFormat` says; version 1 has no such section.
struct Format {
  double version = 1.0;
  bool is_binary = false;
};

/// A section of versions 1 and 2: a count, then a line for each.
void read_flat_section(Lines& lines, Numbers& numbers) {
  std::string line;
  if (!lines.next(line)) return;
  const std::vector<Number> count = leading_numbers(line, 1);
  for (Number i = 0; !count.empty() && i < count[0] && lines.next(line); ++i) {
    const std::vector<Number> number = leading_numbers(line, 1);
    if (number.empty()) return;  // $End..., or broken: gmsh says so
    numbers.add(number[0], lines.number());
  }
}

/// A section of version 4: blocks that each begin with four numbers, the last of which is their count. In
/// version 4.1 the coordinates of a block of nodes follow after all of its numbers.
void read_block_section(Lines& lines, bool has_separate_coordinates, Numbers& numbers) {
  std::string line;
  if (!lines.next(line)) return;
  const std::vector<Number> header = leading_numbers(line, 2);
  for (Number block = 0; !header.empty() && block < header[0] && lines.next(line); ++block) {
    const std::vector<Number> entity = leading_numbers(line, 4);
    if (entity.size() < 4) return;
    for (Number i = 0; i < entity[3] && lines.next(line); ++i) {
      const std::vector<Number> number = leading_numbers(line, 1);
      if (number.empty()) return;
      numbers.add(number[0], lines.number());
    }
    for (Number i = 0; has_separate_coordinates && i < entity[3]; ++i) {
      if (!lines.next(line)) return;
    }
  }
}

/// Nodes of an element kind, for those that a mesh of ours may hold; nothing for others, which are refused
/// later by name.
std::optional<std::size_t> nodes_of_kind(Number kind) {
  switch (kind) {
    case 1:
      return 2;
    case 2:
      return 3;
    case 4:
      return 4;
    case 15:
      return 1;
    default:
      return std::nullopt;
  }
}

template <typename T>
bool read_binary(std::istream& bytes, T& value) {
  std::array<char, sizeof(T)> raw{};
  if (!bytes.read(raw.data(), raw.size())) return false;
  std::memcpy(&value, raw.data(), raw.size());
  return true;
}

/// Version 2 in binary: the count as text, then number and coordinates (nodes), or groups of elements.
void read_binary_flat(Lines& lines, bool is_nodes, Numbers& numbers) {
  std::string line;
  if (!lines.next(line)) return;
  const std::vector<Number> count = leading_numbers(line, 1);
  std::istream& bytes = lines.bytes();
  for (Number i = 0; !count.empty() && i < count[0];) {
    if (is_nodes) {
      std::int32_t number = 0;
      if (!read_binary(bytes, number) || !bytes.ignore(3 * sizeof(double))) return;
      numbers.add(number, 0);
      ++i;
      continue;
    }
    std::array<std::int32_t, 3> group{};  // kind, how many, tags of each
    if (!read_binary(bytes, group)) return;
    const auto nodes = nodes_of_kind(group[0]);
    if (!nodes || group[1] < 1 || group[2] < 0) return;
    for (std::int32_t k = 0; k < group[1]; ++k, ++i) {
      std::int32_t number = 0;
      const auto rest =
          static_cast<std::streamsize>(sizeof(std::int32_t) * (static_cast<std::size_t>(group[2]) + *nodes));
      if (!read_binary(bytes, number) || !bytes.ignore(rest)) return;
      numbers.add(number, 0);
    }
  }
}

/// Version 4.1 in binary.
void read_binary_blocks(Lines& lines, bool is_nodes, Numbers& numbers) {
  std::istream& bytes = lines.bytes();
  std::array<std::uint64_t, 4> header{};  // blocks, entries, least and greatest number
  if (!read_binary(bytes, header)) return;
  for (std::uint64_t block = 0; block < header[0]; ++block) {
    std::array<std::int32_t, 3> entity{};  // dimension and tag, then kind (elements) or parametric (nodes)
    std::uint64_t count = 0;
    if (!read_binary(bytes, entity) || !read_binary(bytes, count) || count > header[1]) return;
    const auto nodes = is_nodes ? std::size_t{0} : nodes_of_kind(entity[2]).value_or(0);
    if (!is_nodes && nodes == 0) return;
    for (std::uint64_t i = 0; i < count; ++i) {
      std::uint64_t number = 0;
      if (!read_binary(bytes, number)) return;
      numbers.add(static_cast<Number>(number), 0);
      if (!is_nodes && !bytes.ignore(static_cast<std::streamsize>(8 * nodes))) return;
    }
    if (is_nodes && !bytes.ignore(static_cast<std::streamsize>(3 * sizeof(double) * count))) return;
  }
}

void read_section(Lines& lines, const Format& format, bool is_nodes, Numbers& numbers) {
  const bool has_blocks = format.version >= 4.0;
  if (format.is_binary && has_blocks && format.version < 4.05) return;  // 4.0 in binary: left to gmsh
  if (format.is_binary)
    return has_blocks ? read_binary_blocks(lines, is_nodes, numbers)
                      : read_binary_flat(lines, is_nodes, numbers);
  if (!has_blocks) return read_flat_section(lines, numbers);
  read_block_section(lines, is_nodes && format.version > 4.05, numbers);
}

}  // namespace

void check_numbers_differ(const std::filesystem::path& path) {
  Lines lines(path);
  Format format;
  Numbers nodes(path.string(), "node");
  Numbers elements(path.string(), "element");
  std::string line;
  while (lines.next(line)) {
    if (line.rfind("$MeshFormat", 0) == 0 && lines.next(line)) {
      std::from_chars(line.data(), line.data() + line.size(), format.version);
      const std::size_t space = line.find(' ');
      format.is_binary = space != std::string::npos && line.compare(space, 2, " 1") == 0;
    }
    const bool is_nodes = line.rfind("$Nodes", 0) == 0 || line.rfind("$NOD", 0) == 0;
    const bool is_elements = line.rfind("$Elements", 0) == 0 || line.rfind("$ELM", 0) == 0;
    if (is_nodes) read_section(lines, format, true, nodes);
    if (is_elements) read_section(lines, format, false, elements);
  }
}

}  // namespace palpate::reference
